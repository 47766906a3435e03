"""The knobs of a world as sliders in its page, and what other pages learn of it."""

import pytest

from ecs_eco.testing.browser import until
from tests.view.pages import IN_A_BROWSER, opened, passed, pause

pytestmark = IN_A_BROWSER
LOG = "document.querySelector('#act .log').textContent"
RUN = "wolf: running speed"


@pytest.fixture
def act(page):
    page.locator("#tab-act").click()
    pause(page)
    page.get_by_label(RUN, exact=True).wait_for()
    return page


def test_knobs_come_first_as_sliders_between_their_ends_with_unit(act):
    page = act
    assert page.locator("#act fieldset legend").first.inner_text() == "Knobs"
    slider = page.get_by_label(RUN, exact=True)
    assert slider.evaluate("it => [it.min, it.max]") == ["0.5", "2"]
    assert page.locator("#act .knobs output").all_inner_texts()[2] == "1.3 m/s"
    assert page.locator("#act .knobs input").count() == 6


def test_a_knob_is_turned_undone_and_reset(act):
    page = act
    slider = page.get_by_label(RUN, exact=True)
    undo, reset = (
        page.locator("#act .undo").get_by_role("button", name=name, exact=True)
        for name in ("Undo", "Reset all")
    )
    one = page.get_by_label(f"Reset {RUN}", exact=True)
    before = float(slider.input_value())
    assert undo.is_disabled()
    slider.focus()
    page.keyboard.press("End")
    until(page, f"{LOG}.includes('species.wolf.locomotion.speed.run = 2')")
    page.keyboard.press("Home")
    until(page, f"{LOG}.includes('species.wolf.locomotion.speed.run = 0.5')")
    passed(page)
    assert float(slider.input_value()) == 0.5
    undo.click()
    assert float(slider.input_value()) == 2
    one.click()
    assert float(slider.input_value()) == before
    assert one.is_disabled()
    reset.click()
    assert undo.is_disabled()
    passed(page)
    assert float(slider.input_value()) == before


def test_what_another_page_turns_is_seen_on_this_one(act, browser):
    page = act
    turned = "document.querySelectorAll('#act .knobs output')[2].textContent"
    with opened(browser, page.run.address()) as other:
        other.locator("#tab-act").click()
        until(other, f"{turned} === '1.3 m/s'")
        other.get_by_label(RUN, exact=True).focus()
        other.keyboard.press("End")
        passed(other)
        until(page, f"{turned} === '2 m/s'")
        other.get_by_label(f"Reset {RUN}", exact=True).click()
        passed(other)
        until(page, f"{turned} === '1.3 m/s'")


def test_the_log_is_the_same_on_all_pages_and_refusals_are_marked(act, browser):
    page = act
    page.get_by_label("Parameter").fill("species.deer.metabolism.energy_max")
    page.get_by_label("New value").fill("0.0001")
    page.get_by_role("button", name="Change", exact=True).click()
    refused = page.locator("#act .log li.error").first
    refused.wait_for()
    assert "refused: species.deer.metabolism.energy_max = 0.0001" in refused.inner_text()
    assert float(page.get_by_label("New value").input_value()) == 1  # as it was
    with opened(browser, page.run.address()) as other:
        other.locator("#tab-act").click()
        texts = "[...document.querySelectorAll('#act .log li span')].map(it => it.textContent)"
        until(other, f"{texts}.length")
        assert other.evaluate(texts) == page.evaluate(texts)
        assert page.locator("#act .log li b").first.inner_text() == "this page"
        assert other.locator("#act .log li b").first.inner_text() == "page 1"
        other.get_by_role("button", name="Remove all fences").click()
        until(page, f"{texts}[0].includes('remove fences')")
        assert page.locator("#act .log li b").first.inner_text().startswith("page ")
        passed(other)
