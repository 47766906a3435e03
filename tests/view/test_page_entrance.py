"""Who gets in: a code works once, and pages from elsewhere get nothing."""

import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from types import SimpleNamespace

import pytest

from ecs_eco.testing.browser import entered, served, until
from ecs_eco.view.entrance import Entrance
from ecs_eco.view.guard import SUBPROTOCOL
from tests.view.pages import IN_A_BROWSER, SMALL, WIDE

pytestmark = IN_A_BROWSER


class Elsewhere(BaseHTTPRequestHandler):
    """A page of another origin."""

    def do_GET(self):
        self.send_response(200)
        self.send_header("content-type", "text/html")
        self.end_headers()
        self.wfile.write(b"<!doctype html><title>elsewhere</title>")

    def log_message(self, *_):
        pass


@pytest.fixture
def stranger(browser):
    """A tab in a browser that nobody let in. A test uses each address of the park that it asks for:
    then there is another one."""
    context = browser.new_context(viewport=WIDE)
    context.set_default_timeout(180_000)
    yield context.new_page()
    context.close()


SEEN = "ecs.frames > 0 && ecs.connected"


def test_the_code_leaves_the_address_and_the_page_can_be_loaded_again(page, stranger):
    address = page.run.address()
    place, _, code = address.partition("#")
    stranger.goto(address)
    until(stranger, SEEN)
    assert stranger.url == place
    assert code not in stranger.evaluate(
        "JSON.stringify([location.href, history.length, document.referrer, {...sessionStorage}])"
    )
    assert stranger.context.cookies() == []
    stranger.reload()
    until(stranger, SEEN)
    assert stranger.url == place


def test_a_used_up_code_lets_nobody_in_and_the_next_one_does_in_the_same_tab(browser, page, stranger):
    with browser.new_context() as other:
        first, address = other.new_page(), page.run.address()
        first.goto(address)
        until(first, SEEN)
    stranger.goto(address)
    until(stranger, "ecs.refused && !document.querySelector('#notice').hidden")
    assert "works only once" in stranger.locator("#notice").inner_text()
    assert stranger.evaluate("ecs.frames") == 0
    stranger.goto(page.run.address())  # which changes the fragment alone: the page is not loaded anew
    until(stranger, SEEN)
    assert "#" not in stranger.url


def test_without_a_code_or_with_the_credential_of_another_port_the_page_shows_no_data(page, stranger):
    stranger.goto(page.url)
    until(stranger, "ecs.refused")
    with served("watch", "predator-prey", *SMALL) as run:
        credential = entered(run.address())[1]
        stranger.evaluate("credential => sessionStorage.setItem('credential', credential)", credential)
        stranger.reload()
        until(stranger, "ecs.refused")
    assert stranger.evaluate("ecs.frames") == 0


def test_the_private_file_takes_a_browser_to_the_page(page, stranger, monkeypatch):
    place, _, code = page.run.address().partition("#code=")
    opened = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or True)
    server = SimpleNamespace(address=lambda minutes=1.0: f"{place}#code={code}")
    entrance = Entrance(server, lambda address: None)
    assert entrance.open_browser()
    stranger.goto(opened[0])
    stranger.wait_for_url(f"{place}**")
    until(stranger, SEEN)
    assert stranger.url == place
    entrance.close()


def test_a_page_from_elsewhere_gets_nothing_even_with_a_good_code(page, stranger):
    address = page.run.address()
    place, _, code = address.partition("#code=")
    with HTTPServer(("127.0.0.1", 0), Elsewhere) as other:
        threading.Thread(target=other.serve_forever, daemon=True).start()
        elsewhere = f"http://127.0.0.1:{other.server_port}"
        stranger.goto(elsewhere)
        ask = (
            "([url, authorization]) => fetch(url, {method: 'POST', headers: "
            "{authorization}}).then(() => 'had', () => 'refused')"
        )
        assert stranger.evaluate(ask, [f"{place}enter", f"Code {code}"]) == "refused"
        hear = """([url, words]) => new Promise(is => {
            const s = new WebSocket(url, words); s.onopen = () => is('had'); s.onclose = () => is('refused') })"""
        credential = entered(address)[1]  # good still
        assert (
            stranger.evaluate(hear, [f"{place.replace('http', 'ws')}ws", [SUBPROTOCOL, credential]])
            == "refused"
        )
        assert stranger.evaluate("url => fetch(url).then(() => 'had', () => 'refused')", place) == "refused"
        other.shutdown()
