"""The first minute: who eats whom, what this world is, and hints that go away."""

from ecs_eco.testing.browser import until
from tests.view.pages import IN_A_BROWSER, select

pytestmark = IN_A_BROWSER


def test_the_food_web_is_drawn_from_the_diets(page):
    page.locator("#tab-world").click()
    meals = page.locator("#world [data-meal]").evaluate_all("all => all.map(path => path.dataset.meal)")
    assert sorted(meals) == ["deer wolf", "grass deer"]
    label = page.locator("#world svg.web").get_attribute("aria-label")
    assert label == "Who eats whom: deer eats grass; wolf eats deer"
    tops = page.locator("#world svg.web text").evaluate_all(
        "all => Object.fromEntries(all.map(text => [text.textContent, +text.getAttribute('y')]))"
    )
    assert tops["grass"] > tops["deer"] > tops["wolf"]  # grass at the bottom, wolf at the top
    assert "60 × 60 m" in page.locator("#world").inner_text()


def test_who_eats_in_a_circle_has_a_place_too(page):
    found = page.evaluate(
        "import('/world.js').then(it => it.levels(['a', 'b', 'c', 'd'], "
        "{b: ['a', 'b'], c: ['d', 'b'], d: ['c']}))"
    )
    assert found["a"] == 0
    assert found["b"] == 1
    assert all(0 < found[name] < 4 for name in "cd")


def test_hints_go_when_they_are_closed_or_followed_and_stay_away(browser, park):
    park.evaluate("localStorage.removeItem('ecs-eco-hints')")
    park.reload()
    until(park, "ecs.frames > 0 && ecs.renders > 0 && ecs.connected && ecs.messages.state > 0")
    hints = park.locator("[data-hint]")
    assert hints.count() == 3
    park.locator("[data-hint=pause] button").click()
    assert hints.count() == 2
    park.locator("#tab-why").click()
    assert hints.count() == 1
    if park.evaluate("ecs.playing"):
        park.locator("#play").click()
    until(park, "!ecs.playing && ecs.still")
    select(park, "deer")
    assert not park.locator("#hints").is_visible()
    park.reload()
    until(park, "ecs.frames > 0 && ecs.connected && ecs.messages.state > 0")
    assert not park.locator("#hints").is_visible()
