"""The page for everybody: by keyboard, on a phone, in either theme, with words that stand out."""

import pytest

from ecs_eco.testing.browser import until
from tests.view.pages import IN_A_BROWSER, PHONE, pause, select, violations

pytestmark = IN_A_BROWSER


def test_colours_themes_and_help_by_keyboard_on_a_phone(page):
    page.emulate_media(color_scheme="dark")
    page.set_viewport_size(PHONE)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    until(page, "document.documentElement.dataset.shade === 'dark'")
    ground = page.evaluate("getComputedStyle(document.body).backgroundColor")
    page.locator("#canvas").focus()
    page.keyboard.press("t")
    assert page.evaluate("document.documentElement.dataset.shade") == "light"
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") != ground
    page.keyboard.press("c")
    assert page.locator("#colour").input_value() == "energy"
    page.locator("#colour").select_option("species")
    page.locator("#canvas").focus()
    page.keyboard.press("?")
    assert page.locator("#help").is_visible()
    assert "play or pause" in page.locator("#help").inner_text()
    page.keyboard.press("Escape")
    assert not page.locator("#help").is_visible()


WALK = """() => {
  const at = document.activeElement, style = getComputedStyle(at);
  const name = at.getAttribute("aria-label") || at.labels?.[0]?.innerText || at.innerText || at.title;
  return [at.id || at.className || at.tagName, (name ?? "").trim(), style.outlineStyle !== "none" || style.boxShadow !== "none"];
}"""  # noqa: E501
CONTRAST = """() => {
  const pen = document.createElement("canvas").getContext("2d", {willReadFrequently: true});
  const rgba = (colour) => {
    pen.clearRect(0, 0, 1, 1);
    pen.fillStyle = colour;
    pen.fillRect(0, 0, 1, 1);
    return [...pen.getImageData(0, 0, 1, 1).data];
  };
  const over = (top, under) => [0, 1, 2].map((k) => top[k] * top[3] / 255 + under[k] * (1 - top[3] / 255));
  const light = (rgb) => rgb.map((v) => v / 255).map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, k) => sum + v * [0.2126, 0.7152, 0.0722][k], 0);
  const behind = (element) => {
    if (!element) return [255, 255, 255];
    const colour = rgba(getComputedStyle(element).backgroundColor);
    return colour[3] === 255 ? colour.slice(0, 3) : over(colour, behind(element.parentElement));
  };
  const found = [];
  for (const element of document.querySelectorAll("body *")) {
    const words = [...element.childNodes].filter((node) => node.nodeType === 3).map((node) => node.data.trim()).join(" ").trim();
    if (!words || !element.checkVisibility() || element.closest(":disabled, [hidden], .unseen, .skip")) continue;
    const under = behind(element), style = getComputedStyle(element);
    const [a, b] = [light(over(rgba(element.closest("svg") ? style.fill : style.color), under)), light(under)];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < 4.5) found.push(`${words.slice(0, 30)}: ${ratio.toFixed(2)}`);
  }
  return found;
}"""  # noqa: E501


def test_the_keyboard_reaches_everything_that_has_a_name_and_shows_where_it_is(page):
    pause(page)
    page.locator("#tab-act").click()
    page.locator(".skip").focus()
    page.keyboard.press("Tab")
    page.keyboard.press("Shift+Tab")  # so that the browser knows that somebody uses the keyboard
    seen = []
    for _ in range(60):
        seen.append(page.evaluate(WALK))
        if seen[-1][0] == "BODY":
            break
        page.keyboard.press("Tab")
    reached = [where for where, _, _ in seen]
    assert {"skip", "theme", "helpOpen", "canvas", "colour", "play", "step", "speed", "tab-act"} <= set(
        reached
    )
    assert len(reached) > 25  # with the buttons of the legend, the camera and the panel
    assert [where for where, name, _ in seen if not name and where != "BODY"] == []
    assert [where for where, _, shown in seen if not shown and where != "BODY"] == []


@pytest.mark.parametrize("shade", ["light", "dark"])
def test_all_words_stand_out_from_their_ground(page, shade):
    pause(page)
    if page.evaluate("document.documentElement.dataset.shade") != shade:
        page.locator("#theme").click()
    page.locator("#colour").select_option("energy")
    select(page, "deer")
    for panel in ("charts", "organism", "act"):
        page.locator(f"#tab-{panel}").click()
        assert page.evaluate(CONTRAST) == [], panel
    page.locator("#title").evaluate("title => title.style.color = '#7a7a7a'")
    assert len(page.evaluate(CONTRAST)) == 1
    page.locator("#title").evaluate("title => title.style.color = ''")
    page.locator("#colour").select_option("species")


@pytest.mark.parametrize("size", [(844, 390), (640, 400), (390, 844)])
def test_the_world_has_room_on_phones_on_their_side_and_on_enlarged_pages(page, size):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    box = page.locator("#stage").bounding_box()
    assert box["width"] * box["height"] > 0.4 * size[0] * size[1]
    assert box["height"] > 0.4 * size[1]
    for button in ("#play", "#step", "#tab-charts"):
        inside = page.locator(button).bounding_box()
        assert inside["y"] + inside["height"] <= size[1]


@pytest.mark.parametrize("shade", ["light", "dark"])
def test_axe_finds_nothing_in_any_tab(page, shade):
    pause(page)
    if page.evaluate("document.documentElement.dataset.shade") != shade:
        page.locator("#theme").click()
    select(page, "deer")
    for panel in page.locator("[role=tab]:not([hidden])").all():
        panel.click()
        assert violations(page) == [], panel
