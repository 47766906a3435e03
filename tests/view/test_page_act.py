"""What people do to a world in its page: fences by clicks, values taken back, switches as they stand."""

import pytest

from ecs_eco import World
from ecs_eco.testing.browser import served, until
from ecs_eco.view.live import Live
from tests.view.pages import IN_A_BROWSER, SMALL, in_sight, opened, passed, pause, play

pytestmark = IN_A_BROWSER
LOG = "document.querySelector('#act .log').textContent"


@pytest.fixture
def act(page):
    page.locator("#tab-act").click()
    pause(page)
    undo, reset = undos(page)
    if undo.is_enabled():  # what other tests did
        answers = page.evaluate("ecs.messages.said")
        reset.click()
        until(page, f"ecs.messages.said > {answers} && document.querySelector('#act .undo button').disabled")
        page.wait_for_timeout(1000)  # the world may have gone back: until the page is told so
        until(page, "ecs.still")
    passed(page)
    return page


def undos(page):
    """The buttons that undo the last change and all changes."""
    return [page.locator("#act .undo").get_by_role("button", name=name) for name in ("Undo", "Reset all")]


def test_a_fence_goes_around_two_clicked_corners_and_is_taken_away(act):
    page = act
    page.locator("[data-eye=top]").click()
    until(page, "ecs.still")
    button, notice = page.get_by_role("button", name="Put up a fence"), page.locator("#notice")
    button.click()
    assert notice.inner_text() == "Click one corner of the fence in the scene. Esc stops."
    corners = page.evaluate("ecs.corners()")
    middle = [sum(axis) / len(corners) for axis in zip(*corners, strict=True)]
    page.mouse.click(middle[0] - 60, middle[1] - 50)
    assert notice.inner_text() == "Click the opposite corner of the fence. Esc stops."
    assert "fence" not in page.evaluate(LOG)
    page.mouse.click(middle[0] + 60, middle[1] + 50)
    until(page, f"{LOG}.includes('fence')")
    assert not notice.is_visible()
    assert button.get_attribute("aria-pressed") == "false"
    page.get_by_role("button", name="Remove all fences").click()
    until(page, f"{LOG}.split('fence').length > 2")


def test_escape_takes_a_half_made_fence_back(act):
    page = act
    page.get_by_role("button", name="Put up a fence").click()
    page.locator("#canvas").focus()
    page.keyboard.press("Escape")
    assert not page.locator("#notice").is_visible()
    assert "aim" not in (page.locator("#canvas").get_attribute("class") or "")
    assert page.evaluate("ecs.acts") >= 0
    in_sight(page, "deer")  # clicks select again


def test_what_was_culled_and_placed_is_undone_and_nothing_else(act):
    page = act
    tick = page.evaluate("ecs.tick")
    undo, reset = undos(page)
    page.get_by_label("Kind to cull").select_option("wolf")
    page.get_by_role("button", name="Cull", exact=True).click()
    page.get_by_label("Kind to cull").select_option("deer")
    page.get_by_role("button", name="Cull", exact=True).click()
    passed(page)
    until(page, "ecs.counts.deer === 64 && ecs.counts.wolf === 10")  # 20% of 80 and of 12
    page.get_by_label("Kind to place").select_option("wolf")
    page.get_by_label("How many").fill("7")
    page.get_by_role("button", name="At random positions").click()
    passed(page)
    passed(page)
    until(page, "ecs.counts.wolf === 17")
    undo.click()
    until(page, f"ecs.tick === {tick + 1} && ecs.counts.wolf === 10 && ecs.still")
    passed(page)
    assert page.evaluate("ecs.counts.wolf") == 10
    undo.click()
    until(page, f"ecs.tick === {tick} && ecs.counts.deer === 80 && ecs.counts.wolf === 12 && ecs.still")
    passed(page)  # the cull of wolves, of the same tick, is carried out again
    until(page, "ecs.counts.deer === 80 && ecs.counts.wolf === 10")
    reset.click()
    until(page, f"ecs.tick === {tick} && ecs.still")
    passed(page)
    assert page.evaluate("ecs.counts").items() >= {"deer": 80, "wolf": 12}.items()
    assert undo.is_disabled()


def test_a_world_does_not_go_back_further_than_it_can_to_undo():
    world = World.from_config("predator-prey", seed=1, policies="random")
    live = Live(world)
    world.run(3)
    live.ring.look()
    world.run(2)
    with pytest.raises(ValueError, match="undo: this world can go back only to tick 3, and not to 2"):
        live.handle({"kind": "seek", "tick": 2, "undo": True})
    live.handle({"kind": "seek", "tick": 4, "undo": True})
    assert live.tick == 4


def test_a_changed_value_is_taken_back_and_all_of_them(act):
    page = act
    key, value = page.get_by_label("Parameter"), page.get_by_label("New value")
    undo, reset = undos(page)
    assert undo.is_disabled()
    key.fill("species.deer.metabolism.handling_time")
    first = float(value.input_value())
    for number in (2.5, 3.5):
        value.fill(str(number))
        page.get_by_role("button", name="Change", exact=True).click()
        until(page, f"{LOG}.includes('{number}')")
    undo.click()
    assert float(value.input_value()) == 2.5
    reset.click()
    assert float(value.input_value()) == first
    assert undo.is_disabled()
    passed(page)


def test_a_value_is_chosen_by_sliding_between_its_bounds(act):
    page = act
    page.get_by_label("Parameter").fill("species.deer.diet.0.chance")
    slider = page.get_by_label("Value slider")
    assert (slider.get_attribute("min"), slider.get_attribute("max")) == ("0", "1")
    slider.focus()
    page.keyboard.press("Home")
    assert page.get_by_label("New value").input_value() == "0"


def test_switches_say_how_they_stand(act):
    page = act
    off, on = (page.get_by_label(f"reproduction {word}", exact=True) for word in ("off", "on"))
    assert on.get_attribute("aria-pressed") == "true"
    page.get_by_label("Species", exact=True).select_option("deer")
    off.click()
    passed(page)
    until(page, "document.querySelector('[data-switch=\"reproduction false\"]').ariaPressed === 'true'")
    assert on.get_attribute("aria-pressed") == "false"
    page.get_by_label("Species", exact=True).select_option("wolf")
    assert on.get_attribute("aria-pressed") == "true"
    page.get_by_label("Species", exact=True).select_option("all species")
    assert on.get_attribute("aria-pressed") == off.get_attribute("aria-pressed") == "false"
    on.click()
    passed(page)
    until(page, "document.querySelector('[data-switch=\"reproduction true\"]').ariaPressed === 'true'")


def test_the_legend_says_who_learns_until_learning_is_switched_off(browser):
    trained = [word for word in SMALL if word not in ("--policies", "random")]
    row = "[...document.querySelectorAll('.legend-line')].find(row => row.textContent.startsWith(name))"
    learns = f"name => {row}.textContent.includes('learns')"
    with served("watch", "predator-prey", *trained) as run, opened(browser, run.address()) as page:
        play(page)
        until(page, f"({learns})('deer') && ({learns})('wolf')")
        assert not page.evaluate(learns, "grass")
        page.locator("#tab-act").click()
        pause(page)
        page.get_by_label("Species", exact=True).select_option("deer")
        page.get_by_label("learning off", exact=True).click()
        passed(page)
        page.locator("#play").click()
        until(page, f"!({learns})('deer') && ({learns})('wolf')")
