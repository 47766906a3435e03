"""Pages in a real browser, the parks that they show, and a server without a browser."""

import threading
from types import SimpleNamespace

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.testing.browser import launched, served
from ecs_eco.view import server as module
from ecs_eco.view.live import Live
from ecs_eco.view.player import Player
from ecs_eco.view.replay import Replay
from ecs_eco.view.server import Server
from tests.view.pages import FORGET_THEME, SMALL, WIDE, opened, pause
from tests.view.replays import MADE, record


@pytest.fixture(scope="module")
def browser():
    with launched() as chromium:
        yield chromium


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


@pytest.fixture(scope="module")
def folders(menagerie, tmp_path_factory):
    """The same run, recorded without details, and with all of them."""
    place = tmp_path_factory.mktemp("replay")
    config = menagerie(**MADE)
    record(config, place / "plain", checkpoint_every=20, keep=9)
    record(config, place / "full", record="full")
    return place


@pytest.fixture
def plain(folders):
    """Its replay without details."""
    return Replay(folders / "plain")


@pytest.fixture
def full(folders):
    """Its replay with all of them."""
    return Replay(folders / "full")


@pytest.fixture(scope="module", name="served")
def server_of_mites(tmp_path_factory):
    """A server of a page of one line, and of a world of 2,000 mites that lives in a thread of its own."""
    static = tmp_path_factory.mktemp("view") / "static"
    static.mkdir()
    (static / "index.html").write_text('<p>the page</p><script type="module" src="page.js"></script>')
    (static / "page.js").write_text('import { a } from "./other.js"')
    (static / "other.js").write_text("export const a = 1;")
    (static.parent / "secret.txt").write_text("secret")
    before, module.STATIC = module.STATIC, static
    ready, made = threading.Event(), SimpleNamespace()

    def live():
        world = World([100.0, 100.0])
        world.add_table("mite", Position)
        rng = np.random.default_rng(1)
        world.table("mite").request(
            np.zeros(2000, np.uint64),
            {(Position, a): rng.random(2000).astype(np.float32) * 100 for a in "xy"},
        )
        world.flush()
        made.player = Player(Live(world), speed=None)
        made.server = Server(made.player).start()
        ready.set()
        made.player.source.run(made.player.turn)
        made.server.stop()

    thread = threading.Thread(target=live)
    thread.start()
    assert ready.wait(60)
    yield made
    made.player.close()
    thread.join()
    module.STATIC = before
