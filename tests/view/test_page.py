"""The page in a real browser, against the real server: what is seen moves, and what is clicked happens."""

import io
import json
import threading
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.testing.browser import chromium, entered, launched, served, until
from ecs_eco.view.entrance import Entrance
from ecs_eco.view.guard import SUBPROTOCOL

pytest.importorskip("playwright.sync_api", reason='playwright is not installed: pip install -e ".[dev]"')
pytestmark = [pytest.mark.slow,
              pytest.mark.skipif(chromium() is None,
                                 reason="no Chromium here (Debian: apt-get install chromium)")]

PARK = {"space.size": "[60, 60]", "species.grass.count": 300, "species.deer.count": 80,
        "species.wolf.count": 12,
        "species.wolf.diet.0.chance": 0}  # fmt: skip
for animal in ("deer", "wolf"):  # nobody is eaten, starves or is born: tests may take their time
    zero = ("metabolism.basal", "locomotion.cost.walk", "locomotion.cost.run", "reproduction.rate")
    PARK |= {f"species.{animal}.{key}": 0 for key in zero} | {f"species.{animal}.lethal.1.max": 1e9}
SMALL = [*(word for key, value in PARK.items() for word in ("--set", f"{key}={value}")), "--policies",
         "random", "--seed", "3"]
FORGET_THEME = """() => {
  localStorage.removeItem("ecs-eco-theme");
  delete document.documentElement.dataset.theme;
  document.documentElement.dispatchEvent(new Event("themechange"));
}"""
WIDE, PHONE = {"width": 1000, "height": 640}, {"width": 390, "height": 844}
LOCAL = ("data:", "blob:")


@pytest.fixture(scope="module")
def browser():
    with launched() as found:
        yield found


@contextmanager
def opened(browser, address):
    """A page that shows the world; at its end, nothing was complained of and nothing left the machine."""
    context = browser.new_context(viewport=WIDE, has_touch=True)
    context.set_default_timeout(180_000)
    page, problems, asked = context.new_page(), [], []
    page.on("console",
            lambda message: problems.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.on("websocket", lambda socket: asked.append(socket.url))
    try:
        page.goto(address)
        until(page, "ecs.frames > 0 && ecs.renders > 0 && ecs.connected && ecs.messages.state > 0")
        yield page
        assert len(asked) > 10
        assert [url for url in asked
                if not url.startswith(LOCAL) and url.split("/")[2] != address.split("/")[2]] == []
        # software rendering says so of screenshots
        assert [text for text in problems if "GPU stall" not in text] == []
    finally:
        context.close()


@pytest.fixture(scope="module")
def park(browser):
    """Grass, deer and wolves, alive in a process of their own, and the page that shows them."""
    with served("watch", "predator-prey", *SMALL) as run, opened(browser, run.address()) as page:
        page.run = run
        yield page


@pytest.fixture
def page(park):
    """The same page, as if nobody had touched it: a wide one that stands still, with nobody selected."""
    yield park
    park.set_viewport_size(WIDE)
    park.emulate_media(color_scheme="light")
    park.evaluate(FORGET_THEME)
    park.keyboard.press("Escape")
    park.locator("#tab-charts").click()
    pause(park)


def pause(page):
    """Stop, and wait until the scene shows the last tick that was."""
    if page.evaluate("ecs.playing"):
        page.locator("#play").click()
    until(page, "!ecs.playing && ecs.still")


def play(page):
    if not page.evaluate("ecs.playing"):
        page.locator("#play").click()
    until(page, "ecs.playing")


def scene(page):
    """The pixels of the scene without what lies over it: f32[height, width, 3]."""
    from matplotlib.image import imread

    box = page.locator("#canvas").bounding_box()
    return imread(
        io.BytesIO(page.screenshot(clip=box | {"x": box["x"] + 180, "width": box["width"] - 380}))
    )[..., :3]


def in_sight(page, kind):
    """An organism that nothing covers, and where it is on the screen; the page is to look from above."""
    for uid in page.evaluate(f"ecs.uids('{kind}')"):
        at = page.evaluate(f"ecs.screen({uid})")
        if at and page.evaluate("([x, y]) => document.elementFromPoint(x, y)?.id",
                                [at["x"], at["y"]]) == "canvas":
            return uid, at["x"], at["y"]
    raise AssertionError(f"no {kind} in sight")


def select(page, kind):
    """Click one of a kind; returns whom the page has selected then (a neighbour, it may be)."""
    page.locator("[data-eye=top]").click()
    until(page, "ecs.still")
    _, x, y = in_sight(page, kind)
    page.mouse.click(x, y)
    until(page, "ecs.selected !== null")
    page.locator("#organism .who").wait_for()
    return page.evaluate("ecs.selected")


def facts(panel):
    return dict(zip(panel.locator("dt").all_inner_texts(), panel.locator("dd").all_inner_texts(),
                    strict=True))


def test_frames_arrive_and_animals_move_on_the_screen(page):
    pause(page)
    tick = page.evaluate("ecs.tick")
    page.locator("#step").click()  # what other tests asked for is done
    until(page, f"ecs.tick === {tick + 1} && ecs.still")
    before, frames, tick = scene(page), page.evaluate("ecs.frames"), page.evaluate("ecs.tick")
    places, animals = (page.evaluate("ecs.uids('deer').map(ecs.place)"),
                       page.evaluate("[ecs.counts.deer, ecs.counts.wolf]"))
    play(page)
    until(page, f"ecs.frames > {frames + 5} && ecs.tick > {tick + 5}")
    pause(page)
    moved = np.linalg.norm(np.array(page.evaluate("ecs.uids('deer').map(ecs.place)")) - places, axis=1)
    assert (moved > 0.5).mean() > 0.3  # a third of the deer, by half a metre
    assert (abs(scene(page) - before).max(2) > 0.1).mean() > 0.002
    counts = page.evaluate("ecs.counts")
    assert list(counts) == ["grass", "deer", "wolf"]
    assert [counts["deer"], counts["wolf"]] == animals
    assert page.title().startswith("Grass, deer and wolves")
    until(page, "document.querySelectorAll('#charts canvas').length >= 2")


def test_a_paused_world_stands_still_and_a_step_is_one_tick(page):
    play(page)
    pause(page)
    tick, before = page.evaluate("ecs.tick"), scene(page)
    states = page.evaluate("ecs.messages.state")
    page.keyboard.press("+")  # the answer to this is a state: time has passed, had it not stood still
    until(page, f"ecs.messages.state > {states}")
    assert page.evaluate("ecs.tick") == tick
    assert (abs(scene(page) - before) > 0.05).mean() == 0
    page.locator("#step").click()
    until(page, f"ecs.tick === {tick + 1}")
    page.locator("#canvas").focus()
    page.keyboard.press(".")
    until(page, f"ecs.tick === {tick + 2}")
    page.keyboard.press("Space")
    until(page, f"ecs.playing && ecs.tick > {tick + 3}")


def test_a_clicked_animal_shows_its_life_and_its_nervous_system(page):
    pause(page)
    page.locator("#step").click()  # who has never decided has no decisions to show
    until(page, "ecs.tick > 0 && ecs.still")
    uid, panel = select(page, "deer"), page.locator("#organism")
    assert f"#{uid}" in panel.locator(".who").inner_text()
    assert {"age", "energy", "happiness", "sex", "born", "reward"} <= set(facts(panel))
    assert facts(panel)["energy"].endswith("/ 1")
    words = panel.locator(".nerves text").all_text_contents()
    assert {"reflex", "policy", "happiness", "walk", "left", "eat", "energy"} <= set(words)
    assert panel.locator(".nerves").get_attribute("aria-label") == "Nervous system: 14 sensors, 7 actions"
    page.keyboard.press("n")
    until(page, f"ecs.selected !== {uid} && ecs.messages.organism > 1")
    page.keyboard.press("Escape")
    until(page, "ecs.selected === null")


def test_what_a_colour_means_is_said_while_the_world_stands_still(page):
    pause(page)
    page.locator("#colour").select_option("energy")
    until(page, "/0\\s*deer\\s*1/.test(document.querySelector('#ramp').innerText)")
    page.locator("#colour").select_option("species")
    assert not page.locator("#ramp").is_visible()


def test_what_cannot_be_done_is_refused_by_the_browser_or_in_words(page):
    pause(page)
    page.locator("#tab-act").click()
    acts = page.evaluate("ecs.acts")
    page.get_by_label("Parameter").fill("species.grass.reproduction.rate")
    page.get_by_label("New value").fill("-1")
    page.get_by_role("button", name="Change").click()
    assert page.evaluate("ecs.acts") == acts  # below the bound: not even sent
    page.get_by_label("New value").fill("0.05")
    page.get_by_role("button", name="Change").click()
    until(page, "document.querySelector('#act .log "
                "li')?.textContent.includes('species.grass.reproduction.rate = 0.05')")
    page.get_by_label("Parameter").fill("species.deer.metabolism.energy_max")
    page.get_by_label("New value").fill("0.0001")
    page.get_by_role("button", name="Change").click()
    page.locator("#act .log li.error").wait_for()


def test_colours_themes_and_help_by_keyboard_on_a_phone(page):
    page.emulate_media(color_scheme="dark")
    page.set_viewport_size(PHONE)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    until(page, "document.documentElement.dataset.shade === 'dark'")
    ground = page.evaluate("getComputedStyle(document.body).backgroundColor")
    page.locator("#canvas").focus()
    page.keyboard.press("t")
    assert page.evaluate("document.documentElement.dataset.shade") == "light"
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") != ground
    page.keyboard.press("c")
    assert page.locator("#colour").input_value() == "energy"
    page.locator("#colour").select_option("species")
    page.locator("#canvas").focus()
    page.keyboard.press("?")
    assert page.locator("#help").is_visible()
    assert "play or pause" in page.locator("#help").inner_text()
    page.keyboard.press("Escape")
    assert not page.locator("#help").is_visible()


WALK = """() => {
  const at = document.activeElement, style = getComputedStyle(at);
  const name = at.getAttribute("aria-label") || at.labels?.[0]?.innerText || at.innerText || at.title;
  return [at.id || at.className || at.tagName, (name ?? "").trim(), style.outlineStyle !== "none" || style.boxShadow !== "none"];
}"""  # noqa: E501
CONTRAST = """() => {
  const pen = document.createElement("canvas").getContext("2d", {willReadFrequently: true});
  const rgba = (colour) => {
    pen.clearRect(0, 0, 1, 1);
    pen.fillStyle = colour;
    pen.fillRect(0, 0, 1, 1);
    return [...pen.getImageData(0, 0, 1, 1).data];
  };
  const over = (top, under) => [0, 1, 2].map((k) => top[k] * top[3] / 255 + under[k] * (1 - top[3] / 255));
  const light = (rgb) => rgb.map((v) => v / 255).map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, k) => sum + v * [0.2126, 0.7152, 0.0722][k], 0);
  const behind = (element) => {
    if (!element) return [255, 255, 255];
    const colour = rgba(getComputedStyle(element).backgroundColor);
    return colour[3] === 255 ? colour.slice(0, 3) : over(colour, behind(element.parentElement));
  };
  const found = [];
  for (const element of document.querySelectorAll("body *")) {
    const words = [...element.childNodes].filter((node) => node.nodeType === 3).map((node) => node.data.trim()).join(" ").trim();
    if (!words || !element.checkVisibility() || element.closest(":disabled, [hidden], .unseen, .skip")) continue;
    const under = behind(element), style = getComputedStyle(element);
    const [a, b] = [light(over(rgba(element.closest("svg") ? style.fill : style.color), under)), light(under)];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < 4.5) found.push(`${words.slice(0, 30)}: ${ratio.toFixed(2)}`);
  }
  return found;
}"""  # noqa: E501


def test_the_keyboard_reaches_everything_that_has_a_name_and_shows_where_it_is(page):
    pause(page)
    page.locator("#tab-act").click()
    page.locator(".skip").focus()
    page.keyboard.press("Tab")
    page.keyboard.press("Shift+Tab")  # so that the browser knows that somebody uses the keyboard
    seen = []
    for _ in range(60):
        seen.append(page.evaluate(WALK))
        if seen[-1][0] == "BODY":
            break
        page.keyboard.press("Tab")
    reached = [where for where, _, _ in seen]
    assert {"skip", "theme", "helpOpen", "canvas", "colour", "play", "step",
            "speed", "tab-act"} <= set(reached)
    assert len(reached) > 25  # with the buttons of the legend, the camera and the panel
    assert [where for where, name, _ in seen if not name and where != "BODY"] == []
    assert [where for where, _, shown in seen if not shown and where != "BODY"] == []


@pytest.mark.parametrize("shade", ["light", "dark"])
def test_all_words_stand_out_from_their_ground(page, shade):
    pause(page)
    if page.evaluate("document.documentElement.dataset.shade") != shade:
        page.locator("#theme").click()
    page.locator("#colour").select_option("energy")
    select(page, "deer")
    for panel in ("charts", "organism", "act"):
        page.locator(f"#tab-{panel}").click()
        assert page.evaluate(CONTRAST) == [], panel
    page.locator("#title").evaluate("title => title.style.color = '#7a7a7a'")
    assert len(page.evaluate(CONTRAST)) == 1
    page.locator("#title").evaluate("title => title.style.color = ''")
    page.locator("#colour").select_option("species")


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
    assert code not in stranger.evaluate("JSON.stringify([location.href, history.length, document.referrer, "
                                         "{...sessionStorage}])")
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
    assert "works once" in stranger.locator("#notice").inner_text()
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
        ask = ("([url, authorization]) => fetch(url, {method: 'POST', headers: "
               "{authorization}}).then(() => 'had', () => 'refused')")
        assert stranger.evaluate(ask, [f"{place}enter", f"Code {code}"]) == "refused"
        hear = """([url, words]) => new Promise(is => {
            const s = new WebSocket(url, words); s.onopen = () => is('had'); s.onclose = () => is('refused') })"""  # noqa: E501
        credential = entered(address)[1]  # good still
        assert stranger.evaluate(hear,
                                 [f"{place.replace('http', 'ws')}ws", [SUBPROTOCOL, credential]]) == "refused"
        assert stranger.evaluate("url => fetch(url).then(() => 'had', () => 'refused')", place) == "refused"
        other.shutdown()


def test_the_page_says_when_the_run_has_ended(browser):
    with (served("watch", "predator-prey", *SMALL, "--ticks", "2") as run,
          opened(browser, run.address()) as page):
        until(page, "ecs.tick === 2 && !document.querySelector('#notice').hidden")
        assert "has ended" in page.locator("#notice").inner_text()
        run.process.terminate()
        until(page, "ecs.ended")


@pytest.fixture(scope="module")
def recorded(browser, tmp_path_factory):
    """A run that is recorded, stopped as by Ctrl-C; meanwhile somebody clicks: its folder, the manifest,
    and what the page said."""
    from websockets.sync.client import connect

    out = tmp_path_factory.mktemp("page") / "run"
    words = ["run", "predator-prey", *SMALL, "--ticks", "20000", "--checkpoint-every", "50", "--no-report",
             "--out", str(out), "--watch"]
    with served(*words) as run:
        host, credential = entered(run.address())
        with connect(f"ws://{host}/ws", origin=f"http://{host}", subprotocols=[SUBPROTOCOL, credential],
                     max_size=None) as hasty:
            hasty.send('{"kind": "pause"}')  # before too much has passed
            while (isinstance(heard := hasty.recv(180), bytes)
                   or json.loads(heard).get("playing") is not False):
                pass
        with opened(browser, run.address()) as page:
            output = _clicked(page)
            run.process.terminate()
            until(page, "ecs.ended")
        run.process.wait(180)
    return out, json.loads((out / "manifest.json").read_text()), output


def step(page, ticks):
    """Let so many tens of ticks pass, by the keyboard; return the tick then."""
    goal = page.evaluate("ecs.tick") + ticks
    page.locator("#canvas").focus()
    for _ in range(ticks // 10):
        page.keyboard.press("Shift+Period")
    until(page, f"ecs.tick === {goal} && ecs.still")
    return goal


def seek(page, tick):
    page.get_by_label("Time, in ticks").evaluate(f"slider => {{ slider.value = {tick}; "
                                                 f"slider.dispatchEvent(new Event('input')) }}")
    until(page, f"ecs.tick === {tick} && ecs.still && "
                f"document.querySelector('#tick').textContent.replace(/\\D/g, '') === '{tick}'")


def _clicked(page):
    """Place, remove and cull by the mouse, a tick between; return what the page's log says,
    first to last, and who was removed."""
    pause(page)
    tick = step(page, 30)
    removed = select(page, "deer")
    page.locator("#tab-act").click()
    page.get_by_role("button", name="Remove the selected one").click()
    until(page, "document.querySelectorAll('#act .log li').length === 1")
    page.locator("#step").click()
    until(page, f"ecs.tick === {tick + 1} && ecs.still && document.querySelector('#organism "
                ".died')?.textContent.includes('removed')")
    assert removed not in page.evaluate("ecs.uids('deer', 10000)")
    page.get_by_label("Kind to place").select_option("wolf")
    page.get_by_label("How many").fill("7")
    page.get_by_role("button", name="Click into the scene").click()
    box = page.locator("#canvas").bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.get_by_label("Kind to cull").select_option("deer")
    page.get_by_role("button", name="Cull").click()
    until(page, "document.querySelectorAll('#act .log li').length === 3")
    page.locator("#step").click()
    until(page, f"ecs.tick === {tick + 2} && ecs.counts.wolf === 19 && ecs.counts.deer < 70")
    step(page, 20)
    log = page.locator("#act .log li span").all_inner_texts()[::-1]
    return {"tick": tick, "log": log, "removed": removed, "counts": page.evaluate("ecs.counts")}


def test_what_is_clicked_is_recorded_and_comes_out_the_same_again(recorded):
    out, manifest, said = recorded
    tick = said["tick"]
    assert [when for when, _ in manifest["intervened"]] == [tick, tick + 1, tick + 1]
    remove, add, cull = (what for _, what in manifest["intervened"])
    assert (remove["kind"], remove["uids"], remove["cause"]) == ("cull", [said["removed"]], "removed")
    assert (add["kind"], add["species"], add["count"]) == ("add", "wolf", 7)
    assert add["at_place"] == pytest.approx([30, 30], abs=3)  # where it was clicked: the middle
    assert (cull["kind"], cull["species"], cull["share"]) == ("cull", "deer", 0.2)
    assert [f"tick {tick}: " in said["log"][0], f"tick {tick + 1}: " in said["log"][1]] == [True, True]
    assert "cull 20 % of deer" in said["log"][2]
    assert manifest["done"] == tick + 22
    result = CliRunner().invoke(app, ["repeat", str(out), "--quiet"])
    assert result.exit_code == 0, result.output
    assert "the same end" in result.output
    assert manifest["digest"][:12] in result.output


def test_a_recorded_run_is_scrubbed_and_what_was_not_recorded_is_filled_in(browser, recorded):
    out, manifest, output = recorded
    with served("watch", str(out)) as run, opened(browser, run.address()) as page:
        assert page.evaluate("ecs.mode") == "replay"
        assert not page.locator("#tab-act").is_visible()
        pause(page)
        seek(page, 3)
        page.locator("#play").click()
        until(page, "ecs.tick > 5")
        pause(page)
        for tick, counts in ((manifest["done"] - 1, output["counts"]),
                             (output["tick"] - 1, {"deer": 80, "wolf": 12}), (10, {"deer": 80})):
            seek(page, tick)
            assert page.evaluate("ecs.counts").items() >= counts.items()  # as the page saw it live
        uid, panel = select(page, "deer"), page.locator("#organism")
        panel.locator(".note").wait_for()
        assert f"#{uid}" in panel.locator(".who").inner_text()
        assert panel.locator(".nerves").count() == 0
        panel.get_by_role("button", name="Fill in").click()
        panel.locator(".nerves").wait_for()
