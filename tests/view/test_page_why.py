"""What happens is told as it happens, with its cause, and the page says why."""

import pytest

from ecs_eco.testing.browser import served, until
from tests.view.pages import IN_A_BROWSER, SMALL, opened, pause, play, select

pytestmark = IN_A_BROWSER
END = "species.wolf.lethal.1.max=400"  # [s]: all wolves die of age at tick 400, after the page was opened
FASTEST = "it => { it.value = it.max; it.dispatchEvent(new Event('input')) }"


@pytest.fixture(scope="module")
def doomed(browser):
    """A park whose wolves grow too old before the page's eyes."""
    with (
        served("watch", "predator-prey", *SMALL, "--set", END) as run,
        opened(browser, run.address()) as page,
    ):
        assert page.evaluate("ecs.tick") < 400
        page.locator("#speed").evaluate(FASTEST)
        yield page


def test_an_extinction_is_announced_with_its_cause_and_the_page_says_why(doomed):
    page = doomed
    play(page)
    until(page, "ecs.counts.wolf === 0")
    until(page, "document.querySelector('#announce').textContent.includes('died out')")
    pause(page)
    page.locator("#tab-why").click()
    story = page.locator(".story li.extinct")
    assert "Wolf died out" in story.inner_text()
    assert "100% too old" in story.locator("p").inner_text()
    until(page, "document.querySelectorAll('.account h3').length > 2")
    assert "wolf died out" in page.locator(".account").inner_text()
    of = "document.querySelector('.story li.extinct i').style.getPropertyValue('--c')"
    wolf = "document.querySelectorAll('.spark polyline')[2].getAttribute('stroke')"
    colour = page.evaluate(of)
    page.locator("#theme").click()
    assert page.evaluate(of) == page.evaluate(wolf) != colour  # as in the legend
    story.locator(".jump").click()
    assert page.locator("#tab-charts").get_attribute("aria-selected") == "true"


def test_what_people_do_is_told_too(page):
    pause(page)
    page.locator("#tab-act").click()
    page.get_by_label("Kind to cull").select_option("deer")
    page.get_by_role("button", name="Cull", exact=True).click()
    page.locator("#step").click()
    page.locator("#tab-why").click()
    page.locator(".story li.act").first.wait_for()
    assert "cull 20% of deer" in page.locator(".story").inner_text()


def test_an_organism_has_a_sentence_first(page):
    pause(page)
    page.locator("#step").click()
    until(page, "ecs.tick > 0 && ecs.still")
    select(page, "deer")
    said = page.locator("#organism .said").inner_text()
    assert said.startswith("Deer, ")
    assert any(why in said for why in ("its policy", "did nothing", "automatic"))
