"""Pages in a real browser, and the parks that they show."""

import pytest

from ecs_eco.testing.browser import launched, served
from ecs_eco.view.replay import Replay
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
