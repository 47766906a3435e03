"""An organism of either of two worlds is selected, followed and linked to; the panel says of which it is."""

import pytest

from ecs_eco.testing.browser import until
from tests.view.pages import IN_A_BROWSER, opened
from tests.view.test_page_pair import forked, standing, steps  # noqa: F401

pytestmark = IN_A_BROWSER
# follow, and let the first world be drawn before the second one has moved: its picture must not come back
DRAWN_FIRST = """() => {
  [...document.querySelectorAll('#organism button')].find((button) => button.innerText === 'Follow').click();
  document.querySelector('#theme').click();
  document.querySelector('#theme').click();
}"""
WORLD = "document.querySelector('#organism .world')?.innerText"


def seen(page, kind, second=True, skip=()):
    """An organism that nothing covers, and where it is on the screen."""
    of, canvas = ("ecs.second", "canvas2") if second else ("ecs", "canvas")
    for uid in page.evaluate(f"{of}.uids('{kind}')"):
        at = page.evaluate(f"{of}.screen({uid})")
        if (
            uid not in skip
            and at
            and page.evaluate("([x, y]) => document.elementFromPoint(x, y)?.id", [at["x"], at["y"]]) == canvas
        ):
            return uid, at["x"], at["y"]
    raise AssertionError(f"no {kind} in sight")


def click(page, kind, second=True):
    """Click one of a kind; returns whom the page has selected then (a neighbour, it may be)."""
    page.locator("[data-eye=top]").click()
    until(page, "ecs.still && ecs.second.still")
    _, x, y = seen(page, kind, second)
    page.mouse.click(x, y)
    until(page, f"ecs.selected !== null && ecs.second.chosen === {str(second).lower()} && {WORLD}")
    return page.evaluate("ecs.selected")


@pytest.fixture
def both(forked):  # noqa: F811
    """Two worlds, the second one without wolves, and nobody selected in either."""
    yield forked
    forked.keyboard.press("Escape")
    forked.keyboard.press("Escape")
    until(forked, "ecs.selected === null")


def test_a_click_in_either_world_selects_one_of_it_and_the_panel_says_of_which(both):
    page = both
    steps(page, 1)
    uid = click(page, "deer")
    until(page, f"{WORLD}.includes('what if')")
    assert page.locator("#organism .who strong").inner_text().endswith(f"#{uid}")
    assert "born before the worlds diverged" in page.evaluate(WORLD)
    assert page.locator("#organism .nerves").count() == 1
    until(page, f"ecs.second.ring === {uid} && !document.querySelector('.ring:not(#ring)').hidden")
    until(page, "!document.querySelector('#ring').hidden")  # there as well
    wolf = click(page, "wolf", second=False)
    until(page, f"{WORLD}.includes('original')")
    assert page.locator("#organism .who strong").inner_text() == f"wolf #{wolf}"
    page.keyboard.press("Escape")
    until(page, "ecs.selected === null && ecs.second.ring === null && document.querySelector('#ring').hidden")


def test_the_same_deer_is_another_one_in_each_world(both):
    page = both
    page.locator("#tab-act").click()
    click(page, "deer")
    steps(page, 2)
    until(page, "document.querySelector('#organism .state').innerText === 'alive'")
    page.locator("#tab-act").click()
    remove = page.get_by_role("button", name="Remove the selected organism")
    assert remove.is_disabled()  # what is done is done to the first world
    page.locator("#tab-organism").click()
    page.locator("#tab-all").click()
    assert page.locator("#all tr.chosen").count() == 0
    click(page, "deer", second=False)
    until(page, f"!ecs.second.chosen && {WORLD}.includes('original')")
    page.locator("#tab-act").click()
    assert remove.is_enabled()


def test_the_camera_follows_one_of_the_second_world_in_both(both):
    page = both
    uid = click(page, "deer")
    page.evaluate(DRAWN_FIRST)
    until(page, "ecs.still && ecs.second.still")
    assert page.locator("[data-eye=follow]").get_attribute("aria-pressed") == "true"
    box = page.locator("#canvas2").bounding_box()
    middle = [box["x"] + box["width"] / 2, box["y"] + box["height"] / 2]
    for _ in range(2):
        at = page.evaluate(f"ecs.second.screen({uid})")
        assert [at["x"], at["y"]] == pytest.approx(middle, abs=6)
        assert page.evaluate("ecs.camera") == pytest.approx(page.evaluate("ecs.second.camera"), rel=1e-6)
        steps(page, 3)
    page.locator("[data-eye=side]").click()
    until(page, "ecs.still && ecs.second.still")
    assert page.locator("[data-eye=follow]").get_attribute("aria-pressed") == "false"
    assert page.evaluate("ecs.camera") == pytest.approx(page.evaluate("ecs.second.camera"), rel=1e-6)


def test_the_next_one_is_of_the_same_world_and_what_is_closed_takes_its_selection_with_it(both):
    page = both
    uid = click(page, "deer")
    page.keyboard.press("n")
    until(page, f"ecs.selected !== {uid} && ecs.second.chosen && {WORLD}?.includes('what if')")
    page.locator("#pairClose").click()
    until(page, "ecs.second === null && ecs.selected === null")
    assert "Click an organism" in page.locator("#organism").inner_text()
    assert page.locator("[data-eye=follow]").is_disabled()


def test_a_link_brings_one_of_the_second_world_back_and_says_so_where_there_is_none(both, browser):
    page = both
    uid = click(page, "deer")
    page.keyboard.press("k")
    until(page, "location.hash.includes('of=second')")
    link = page.evaluate("location.hash.slice(1)")
    with opened(browser, page.run.address()) as other:
        other.evaluate(f"location.hash = '{link}'")
        until(other, f"ecs.selected === {uid} && ecs.second.chosen && {WORLD}?.includes('what if')")
    page.locator("#pairClose").click()
    until(page, "ecs.second === null")
    with opened(browser, page.run.address()) as other:
        other.evaluate(f"location.hash = '{link}'")
        until(other, "document.querySelector('#notice').innerText.includes('belongs to a second world')")
        assert other.evaluate("ecs.selected") is None
