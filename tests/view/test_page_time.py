"""The timeline: labelled, with lanes; a living world goes back in time, and goes on."""

import pytest

from ecs_eco.testing.browser import until
from tests.view.pages import IN_A_BROWSER, pause, play

pytestmark = IN_A_BROWSER
CHARTED = "Number(document.querySelector('#tick').textContent.replace(/\\D/g, ''))"


@pytest.fixture
def later(page):
    """The page of a living world at tick 60 or later, standing still."""
    play(page)
    until(page, "ecs.tick >= 60")
    pause(page)
    return page


def go(page, tick):
    """Let the slider of time go at a tick."""
    page.get_by_label("Time, in ticks").evaluate(
        "(slider, tick) => { slider.value = tick; slider.dispatchEvent(new Event('input')); "
        "slider.dispatchEvent(new Event('change')) }",
        tick,
    )


def test_a_living_world_goes_back_and_comes_to_the_same_again(later):
    page = later
    tick = page.evaluate("ecs.tick")
    uid = page.evaluate("ecs.uids('wolf')[0]")
    then = page.evaluate(f"ecs.place({uid})")
    go(page, 20)
    until(page, f"ecs.tick === 20 && ecs.still && {CHARTED} === 20")
    assert page.evaluate(f"ecs.place({uid})") != then
    page.locator("#canvas").focus()
    for _ in range((tick - 20) // 10):
        page.keyboard.press("Shift+Period")
    for _ in range((tick - 20) % 10):
        page.keyboard.press("Period")
    until(page, f"ecs.tick === {tick} && ecs.still")
    assert page.evaluate(f"ecs.place({uid})") == pytest.approx(then, abs=1e-6)


def test_one_tick_back(later):
    page = later
    tick = page.evaluate("ecs.tick")
    page.locator("#back").click()
    until(page, f"ecs.tick === {tick - 1} && ecs.still")
    page.locator("#canvas").focus()
    page.keyboard.press(",")
    until(page, f"ecs.tick === {tick - 2} && ecs.still")


def test_a_living_world_does_not_go_where_it_has_not_been(later):
    page = later
    tick = page.evaluate("ecs.tick")
    go(page, tick + 30)
    until(page, f"ecs.tick === {tick} && ecs.still")
    assert page.get_by_label("Time, in ticks").evaluate("slider => Number(slider.max)") > tick
