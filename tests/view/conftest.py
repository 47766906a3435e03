"""Pages in a real browser, and the parks that they show."""

import pytest

from ecs_eco.testing.browser import launched, served
from tests.view.pages import FORGET_THEME, SMALL, WIDE, opened, pause


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
