"""`world.view()`: a page in an output cell, whose world lives between the cells and in their thread."""

import asyncio
import functools
import http.server
import json
import re
import struct
import threading
import urllib.request

import pytest
from websockets.asyncio.client import connect

from ecs_eco import World
from ecs_eco.components import Position, Velocity
from ecs_eco.view import watch
from tests.view.pages import IN_A_BROWSER


def mites():
    world = World([100.0, 100.0], name="mites")
    world.add_table("mite", Position, Velocity)
    world.spawn("mite", n=20)
    return world


async def joined(panel):
    """A WebSocket of a page that came by the address in the output cell."""
    address = re.search(r'src="([^"]+)"', panel._repr_html_())[1]
    base, _, code = address.partition("/#code=")

    def enter():
        request = urllib.request.Request(
            f"{base}/enter", method="POST", headers={"Authorization": f"Code {code}"}
        )
        with urllib.request.urlopen(request) as answer:
            return json.load(answer)["credential"]

    word = await asyncio.to_thread(enter)
    return await connect(base.replace("http", "ws") + "/ws", origin=base, subprotocols=["ecs-eco", word])


async def state(socket, wanted):
    async for message in socket:
        if isinstance(message, bytes):
            (number,) = struct.unpack_from("<I", message, 4)
            await socket.send(json.dumps({"kind": "ack", "frame": number}))
        elif (said := json.loads(message))["kind"] == "state" and wanted(said):
            return said
    raise AssertionError("the page was closed")


def test_the_world_stands_still_until_somebody_presses_play_and_ends_where_it_should():
    async def cells():
        world = mites()
        panel = world.view(5, speed=None)
        try:
            socket = await joined(panel)
            assert (await state(socket, lambda s: True))["tick"] == 0
            assert threading.current_thread() is world.owner
            await socket.send('{"kind": "play"}')
            assert (await state(socket, lambda s: s["done"]))["tick"] == 5
            assert world.tick == 5
            world.run(3)  # another cell
            assert world.tick == 8
            await socket.close()
        finally:
            panel.close()
        assert "closed" in panel._repr_html_()

    asyncio.run(asyncio.wait_for(cells(), 60))


def test_a_second_view_of_a_world_ends_the_first():
    async def cells():
        world = mites()
        first, second = world.view(), world.view()
        try:
            assert "closed" in repr(first)
            assert "iframe" in second._repr_html_()
        finally:
            second.close()

    asyncio.run(asyncio.wait_for(cells(), 60))


def test_pages_of_this_machine_alone_may_frame_it():
    async def cells():
        panel = mites().view()
        try:
            address = re.search(r'src="([^"#]+)', panel._repr_html_())[1]
            with await asyncio.to_thread(urllib.request.urlopen, address) as answer:
                assert "x-frame-options" not in answer.headers
                policy = answer.headers["content-security-policy"]
                assert "frame-ancestors http://localhost:* http://127.0.0.1:*;" in policy
        finally:
            panel.close()

    asyncio.run(asyncio.wait_for(cells(), 60))


def test_outside_of_a_notebook_it_opens_the_browser(monkeypatch):
    asked = {}
    monkeypatch.setattr(watch, "watch", lambda source, **how: asked.update(how, last=source.last))
    assert mites().view(7) is None
    assert asked == {"port": 0, "speed": 10.0, "playing": False, "browser": True, "panels": None, "last": 7}


@pytest.mark.parametrize("browsers", [pytest.param("chromium", marks=IN_A_BROWSER)])
def test_a_notebook_of_another_port_shows_the_living_world(browsers, tmp_path):
    from ecs_eco.testing.browser import launched, until

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *args):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=tmp_path))
    threading.Thread(target=server.serve_forever, daemon=True).start()

    def look(port):
        with launched() as browser:
            page = browser.new_page(viewport={"width": 900, "height": 760})
            page.goto(f"http://localhost:{port}/notebook.html")
            frame = page.frames[1]
            until(frame, "window.ecs && ecs.frames > 0 && ecs.connected")
            frame.locator("#play").click()
            until(frame, "ecs.tick >= 5")
            page.close()

    async def cells():
        world = mites()
        panel = world.view()
        (tmp_path / "notebook.html").write_text(f"<h1>A notebook</h1>{panel._repr_html_()}")
        try:
            await asyncio.to_thread(look, server.server_address[1])
        finally:
            panel.close()
        assert world.tick >= 5

    try:
        asyncio.run(cells())
    finally:
        server.shutdown()
        server.server_close()
