"""What is taken away from the page: pictures, videos, drawings; and the page for a classroom."""

import io
from xml.etree import ElementTree

import numpy as np
import pytest

from ecs_eco.testing.browser import until
from tests.view.pages import IN_A_BROWSER, passed, pause, play

pytestmark = IN_A_BROWSER


def saved(page, click):
    with page.expect_download() as waiting:
        click()
    return waiting.value.suggested_filename, waiting.value.path().read_bytes()


def test_a_picture_of_the_scene_has_its_animals_on_its_ground(page):
    from matplotlib.image import imread

    pause(page)
    name, data = saved(page, page.get_by_role("button", name="Picture", exact=True).click)
    assert name == f"predator-prey-tick-{page.evaluate('ecs.tick')}.png"
    picture = imread(io.BytesIO(data))
    assert picture.shape[1] == 2008  # 17 cm at 300 dots per inch
    assert (picture[..., 3] == 1).all()  # with its sky
    brown = (picture[..., 0] > picture[..., 2] + 0.2) & (picture[..., 0] < 0.7)
    assert brown.mean() > 0.002  # deer


DRAWN = """() => {
  const address = URL.createObjectURL.bind(URL);
  URL.createObjectURL = (blob) => {
    if (blob.type === "image/svg+xml") blob.text().then((text) => (window.drawn = text));
    return address(blob);
  };
}"""


def test_a_picture_has_title_legend_world_seed_and_tick(page):
    from matplotlib.image import imread

    pause(page)
    page.evaluate(DRAWN)
    _, data = saved(page, page.get_by_role("button", name="Picture", exact=True).click)
    words, counts = words_of(ElementTree.fromstring(page.evaluate("drawn"))), page.evaluate("ecs.counts")
    assert words[0] == "Grass, deer and wolves"
    legend = [word.partition(":")[0] for word in words[1:4]]  # another test may have left the color "energy"
    assert legend == [f"{counts[kind]} {kind}" for kind in ("grass", "deer", "wolf")]
    assert words[-1] == origin(page)
    picture = imread(io.BytesIO(data))[..., :3]
    for rows in (picture[20:75, :600], picture[-60:, :600]):  # the letters of the first and the last line
        assert (np.abs(rows - rows[0, 0]).max(axis=2) > 0.2).mean() > 0.01


def test_a_video_is_saved_at_the_second_click(page):
    button = page.get_by_role("button", name="Video", exact=True)
    if not button.count():
        pytest.skip("this browser films no webm")
    play(page)
    button.click()
    assert button.get_attribute("aria-pressed") == "true"
    tick = page.evaluate("ecs.tick")
    until(page, f"ecs.tick > {tick + 8}")
    name, data = saved(page, button.click)
    assert name.endswith(".webm")
    assert data[:4] == b"\x1aE\xdf\xa3"  # EBML
    assert len(data) > 2000
    assert button.get_attribute("aria-pressed") == "false"


FILMED = """() => {
  const { fillText } = CanvasRenderingContext2D.prototype, { captureStream } = HTMLCanvasElement.prototype;
  CanvasRenderingContext2D.prototype.fillText = function (text, ...at) {
    if (this.canvas === window.filmed) window.caption = text;
    return fillText.call(this, text, ...at);
  };
  HTMLCanvasElement.prototype.captureStream = function (...rate) {
    window.filmed = this;
    return captureStream.apply(this, rate);
  };
}"""
LETTERS = """() => { // pixels of letters in the last line of a frame, at both ends, and the height of that line
  const { width, height } = filmed, high = height - document.querySelector("#stage").clientHeight;
  const { data } = filmed.getContext("2d").getImageData(0, height - high, width, high);
  const inked = (x) => Math.abs(data[4 * x] - data[0]) > 60;
  const ink = (from) => Array.from({ length: 300 * high }, (_, i) => inked(width * (i % high) + from + Math.floor(i / high))).filter(Boolean).length;
  return [ink(0), ink(width - 300), high];
}"""  # noqa: E501


def test_frames_of_a_video_have_the_last_line_of_a_picture(page):
    button = page.get_by_role("button", name="Video", exact=True)
    if not button.count():
        pytest.skip("this browser films no webm")
    page.evaluate(FILMED)
    pause(page)
    button.click()
    passed(page)
    until(page, "window.caption")
    assert page.evaluate("caption") == origin(page)
    left, right, high = page.evaluate(LETTERS)
    assert left > 200
    assert right == 0
    assert high == 22
    saved(page, button.click)


def test_a_video_stopped_at_once_still_has_a_picture(page):
    button = page.get_by_role("button", name="Video", exact=True)
    if not button.count():
        pytest.skip("this browser films no webm")
    _, data = saved(page, lambda: button.evaluate("it => { it.click(); it.click(); it.click(); }"))
    assert data[:4] == b"\x1aE\xdf\xa3"
    assert len(data) > 500
    assert button.get_attribute("aria-pressed") == "false"


@pytest.mark.parametrize("title", ["Phase plane", "Distribution", "Organisms"])
def test_figures_are_saved_as_drawings(page, title):
    pause(page)
    toggle = page.locator("#charts .tools .toggle", has_text=title)
    toggle.click()
    if title == "Distribution":
        page.get_by_label("Value of the distribution").select_option("energy")
    page.locator("#charts svg.figure-axes").wait_for()
    _, data = saved(page, page.get_by_label(f"Save the drawing: {title}").click)
    drawing = ElementTree.fromstring(data.decode())
    assert words_of(drawing)[0] == title
    assert words_of(drawing)[-1] == origin(page)
    page.locator("#colour").select_option("species")
    toggle.click()


def words_of(drawing):
    """The texts of a drawing."""
    return [text.text for text in drawing.iter("{http://www.w3.org/2000/svg}text")]


def origin(page):
    return f"Grass, deer and wolves · seed 3 · tick {page.evaluate('ecs.tick')} · ecs-eco"


def test_a_chart_is_saved_for_print_with_title_axes_legend_and_origin(page):
    from matplotlib.image import imread

    play(page)
    until(page, "ecs.tick > 5 && document.querySelectorAll('#charts .u-wrap').length")
    pause(page)
    _, data = saved(page, page.get_by_label("Save the drawing: Populations").click)
    drawing = ElementTree.fromstring(data.decode())
    assert drawing.get("width") == "170mm"
    words = words_of(drawing)
    assert words[:4] == ["Populations", "grass", "deer", "wolf"]
    assert words[-3:] == ["tick", "organisms", origin(page)]
    lines = [one.get("points").split() for one in drawing.iter("{http://www.w3.org/2000/svg}polyline")]
    assert len(lines) == 3
    heights = [[float(point.split(",")[1]) for point in line] for line in lines]
    assert len(set(heights[1])) == 1  # 80 deer at every tick
    assert max(heights[0]) < min(heights[1])  # each in a lane of its own
    _, data = saved(page, page.get_by_label("Save the picture: Populations").click)
    assert imread(io.BytesIO(data)).shape[1] == 2008


def test_a_classroom_has_large_words_and_few_controls_and_is_kept(page):
    size = "parseFloat(getComputedStyle(document.querySelector('#legend .named')).fontSize)"
    play(page)
    until(page, "document.querySelectorAll('#charts .chart').length >= 3")  # charts with buttons of their own
    pause(page)
    before, buttons = page.evaluate(size), "[...document.querySelectorAll('button')]"
    shown = f"{buttons}.filter(button => button.checkVisibility()).length"
    many = page.evaluate(shown)
    page.locator("#classroom").click()
    assert page.evaluate(size) > before + 2
    assert page.evaluate(shown) < 0.6 * many
    assert not page.locator("#tab-act").is_visible()
    assert page.locator("#play").is_visible()
    assert page.evaluate("localStorage.getItem('ecs-eco-classroom')") == "on"
    page.locator("#classroom").click()
    assert page.evaluate(shown) == many
