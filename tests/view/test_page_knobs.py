"""The knobs of a world as sliders in its page, and what other pages learn of it."""

import pytest

from ecs_eco.testing.browser import until
from tests.view.pages import IN_A_BROWSER, opened, passed, pause, play

pytestmark = IN_A_BROWSER
LOG = "document.querySelector('#act .log').textContent"
RUN = "wolf: running speed"


def unfold(page):
    page.locator("#knobs").wait_for()
    if not page.locator("#knobs").evaluate("knobs => knobs.open"):
        page.locator("#knobs summary").click()
    page.get_by_label(RUN, exact=True).wait_for()


@pytest.fixture
def act(page):
    page.locator("#tab-act").click()
    pause(page)
    unfold(page)
    return page


def test_knobs_are_sliders_in_the_scene_between_their_ends_with_unit(act):
    page = act
    scene, knobs = (page.locator(id).bounding_box() for id in ("#stage", "#knobs"))
    assert scene["x"] < knobs["x"]
    assert knobs["x"] + knobs["width"] < scene["x"] + scene["width"]
    assert knobs["y"] + knobs["height"] < scene["y"] + scene["height"]
    slider = page.get_by_label(RUN, exact=True)
    assert slider.evaluate("it => [it.min, it.max]") == ["0.5", "2"]
    assert page.locator("#knobs .knobs output").all_inner_texts()[2] == "1.3 m/s"
    assert page.locator("#knobs .knobs input").count() == 6


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


def test_a_knob_is_turned_beside_the_charts_while_the_world_runs_and_undone_there(page):
    page.locator("#tab-charts").click()
    unfold(page)
    play(page)
    before = float(page.get_by_label(RUN, exact=True).input_value())
    page.get_by_label(RUN, exact=True).focus()
    page.keyboard.press("End")
    until(page, f"{LOG}.includes('species.wolf.locomotion.speed.run = 2')")
    assert page.locator("#charts").is_visible()
    assert page.evaluate("ecs.playing")
    page.locator("#knobs").get_by_role("button", name="Undo", exact=True).click()
    assert float(page.get_by_label(RUN, exact=True).input_value()) == before
    pause(page)
    passed(page)


LATE = """async () => {
  const { Changes } = await import("./knobs.js"), sent = [];
  const changes = new Changes({ send: (what) => sent.push(what.set.speed), back: () => {}, now: () => 0 });
  const told = [], offer = (value) => {
    changes.offer([{ key: "speed", value }]);
    told.push(changes.find("speed").value);
  };
  offer(1);
  changes.make("speed", 2);
  changes.back(1, "undo");
  offer(2); // the answer to the first
  offer(1); // and to the second
  offer(3); // another page turned it
  changes.make("speed", 4);
  changes.refused();
  offer(3);
  offer(5);
  return { sent, told };
}"""


def test_late_answers_to_earlier_changes_do_not_turn_a_knob_back(page):
    assert page.evaluate(LATE) == {"sent": [2, 1, 4], "told": [1, 1, 1, 3, 3, 5]}


def test_knobs_unfold_in_a_wide_scene_fold_on_a_phone_and_stay_as_they_were_left(park, browser):
    def arrives(page, width, height):
        page.set_viewport_size({"width": width, "height": height})
        page.reload()
        until(page, "ecs.frames > 0 && ecs.connected && document.querySelectorAll('#knobs input').length")
        return page.locator("#knobs").evaluate("knobs => knobs.open")

    with opened(browser, park.run.address()) as page:
        assert arrives(page, 1440, 900)
        page.set_viewport_size({"width": 800, "height": 700})
        until(page, "!document.querySelector('#knobs').open")
        assert not arrives(page, 390, 844)
        page.locator("#knobs summary").click()
        assert arrives(page, 390, 844)
        page.locator("#knobs summary").click()
        assert not arrives(page, 1440, 900)


def test_what_another_page_turns_is_seen_on_this_one(act, browser):
    page = act
    turned = "document.querySelectorAll('#knobs .knobs output')[2].textContent"
    with opened(browser, page.run.address()) as other:
        unfold(other)
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
