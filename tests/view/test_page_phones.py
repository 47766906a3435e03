"""The page on phones, upright and on their side, and enlarged: nothing is beyond the edge."""

import pytest

from ecs_eco.testing.browser import served, until
from tests.view.pages import IN_A_BROWSER, PHONE, SMALL, opened, pause, play

pytestmark = IN_A_BROWSER
ENLARGED = (320, 256)  # a window of 1280 x 1024 pixels, enlarged to 400%
SIZES = [(844, 390), (640, 400), (640, 360), (390, 844), (320, 568), ENLARGED]
BEYOND = """() => {
  const {scrollWidth, scrollHeight} = document.documentElement;
  const seen = (tab) => {
    const {left, right, top, bottom} = tab.getBoundingClientRect();
    const inside = [left + 2, right - 2].every((x) => tab.contains(document.elementFromPoint(x, (top + bottom) / 2)));
    return inside && left >= 0 && right <= innerWidth && bottom <= innerHeight;
  };
  const shown = [...document.querySelectorAll("[role=tab]")].filter((tab) => tab.checkVisibility());
  return [shown.length, shown.filter((tab) => !seen(tab)).map((tab) => tab.id), scrollWidth - innerWidth, scrollHeight - innerHeight];
}"""  # noqa: E501

NARROW = """() => [...document.querySelectorAll("button, a, input, select, summary, [role=button], [role=tab]")]
  .filter((one) => one.checkVisibility({opacityProperty: true}) && !one.closest(".skip"))
  .map((one) => [one, ((one.matches("[type=checkbox]") && one.closest("label")) || one).getBoundingClientRect()])
  .filter(([, { width, height }]) => Math.min(width, height) < 24)
  .map(([one, { width, height }]) => [one.id || one.className, one.ariaLabel ?? one.textContent, width, height])"""


def overflows(page, tabs):
    """What is cut, by size and tab."""
    found = []
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        until(page, f"innerWidth === {width} && innerHeight === {height}")
        for tab in page.locator("[role=tab]:visible").all():
            tab.click()
            shown, cut, wide, high = page.evaluate(BEYOND)
            assert shown == tabs
            if cut or wide > 0 or high > 0:
                found.append((width, height, tab.get_attribute("id"), cut, wide, high))
    return found


def everywhere(page, tabs):
    page.keyboard.press("n")
    page.locator("#organism .who").wait_for()
    assert overflows(page, tabs) == []
    page.locator("#classroom").click()
    assert overflows(page, 4) == []
    page.locator("#classroom").click()


def test_nothing_of_a_living_world_is_beyond_the_edge_of_a_phone(page):
    everywhere(page, 6)
    page.set_viewport_size({"width": 640, "height": 360})
    page.locator(".tabs").evaluate("tabs => tabs.style.flexWrap = 'nowrap'")
    assert page.evaluate(BEYOND)[1] != []
    page.locator(".tabs").evaluate("tabs => tabs.style.flexWrap = ''")


def test_nothing_of_a_replay_is_beyond_the_edge_of_a_phone(browser, tmp_path):
    from typer.testing import CliRunner

    from ecs_eco.cli import app

    done = CliRunner().invoke(
        app, ["run", "predator-prey", *SMALL, "--ticks", "20", "--out", str(tmp_path / "run")]
    )
    assert done.exit_code == 0, done.output
    with served("watch", str(tmp_path / "run")) as run, opened(browser, run.address()) as page:
        until(page, "ecs.mode === 'replay'")
        everywhere(page, 5)


def test_panels_of_a_small_phone_have_room_below(page):
    page.set_viewport_size({"width": 320, "height": 568})
    page.locator("#tab-act").click()
    box = page.locator("#act").bounding_box()
    assert box["height"] > 300
    page.locator("#act").get_by_role("slider").first.scroll_into_view_if_needed()
    assert page.locator("#act").bounding_box()["y"] < 400


def test_at_400_percent_the_scene_keeps_its_place_and_controls_are_within_reach(page):
    page.set_viewport_size(dict(zip(("width", "height"), ENLARGED, strict=True)))
    until(page, "innerHeight === 256")
    stage = page.locator("#stage").bounding_box()
    assert (stage["width"], stage["height"] >= 100) == (320, True)
    for control in ("#play", "#step", "#speed", "#tab-charts", "#tab-act", "#helpOpen"):
        page.locator(control).scroll_into_view_if_needed()
        box = page.locator(control).bounding_box()
        ends = box["x"], box["y"], 320 - box["x"] - box["width"], 256 - box["y"] - box["height"]
        assert min(ends) >= 0, control
        middle = [box["x"] + box["width"] / 2, box["y"] + box["height"] / 2]
        hit = "([x, y, id]) => document.querySelector(id).contains(document.elementFromPoint(x, y))"
        assert page.evaluate(hit, [*middle, control]), control


def test_on_a_laptop_time_is_one_row_and_buttons_of_a_timeline_stay_beside_it(page):
    for width, rows in ((1280, 1), (1000, 2)):
        page.set_viewport_size({"width": width, "height": 800})
        until(page, f"innerWidth === {width}")
        boxes = {of: page.locator(of).bounding_box() for of in ("#play", "#timeline", ".spans", ".transport")}
        middle = {of: box["y"] + box["height"] / 2 for of, box in boxes.items()}
        assert abs(middle["#timeline"] - middle[".spans"]) < 2
        assert (abs(middle["#play"] - middle["#timeline"]) < 2) == (rows == 1)
        assert boxes[".spans"]["x"] > boxes["#timeline"]["x"] + 200
        assert boxes[".transport"]["height"] < (110 if rows == 1 else 160)


@pytest.mark.parametrize("size", [(390, 844), (844, 390), (320, 568)])
def test_targets_on_a_phone_are_at_least_24_pixels_wide_and_high(page, size):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    until(page, f"innerWidth === {size[0]}")
    page.keyboard.press("n")
    page.locator("#organism .who").wait_for()
    page.locator(".legend-more").click()
    for tab in page.locator("[role=tab]:visible").all():
        tab.click()
        assert page.evaluate(NARROW) == []
    page.locator(".legend-more").click()


def test_births_deaths_causes_and_hints_are_within_reach_on_a_phone(page):
    page.set_viewport_size(PHONE)
    play(page)
    until(page, "ecs.tick > 5")
    pause(page)
    flow = page.locator(".legend-row .flow").first
    assert not flow.is_visible()
    page.get_by_role("button", name="births, deaths, causes").click()
    assert "per tick" in flow.inner_text()
    assert page.locator(".legend-marks").is_visible()
    page.get_by_role("button", name="less", exact=True).click()
    assert not flow.is_visible()
    page.locator("#helpOpen").click()
    assert "The Why tab explains events" in page.locator("#help").inner_text()
    page.keyboard.press("Escape")
