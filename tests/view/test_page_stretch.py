"""A stretch of the timeline is shown larger, and played again and again."""

import pytest

from ecs_eco.record import run_to_folder
from ecs_eco.testing.browser import served, until
from tests.view.pages import IN_A_BROWSER, PARK, PHONE, SMALL, opened, pause, play, select

pytestmark = IN_A_BROWSER
TICKS = 200
PIXELS = """canvas => {  // how wide the bars of recorded details and of filled stretches are
  const copy = Object.assign(document.createElement("canvas"), {width: canvas.width, height: canvas.height});
  const pen = copy.getContext("2d", {willReadFrequently: true});
  pen.drawImage(canvas, 0, 0);
  const y = Math.round((canvas.clientHeight - 17) * devicePixelRatio);  // above the labels
  const row = [...Array(copy.width).keys()].map(x => [...pen.getImageData(x, y, 1, 1).data]);
  return ["--accent", "--plus"].map(name => {
    pen.fillStyle = getComputedStyle(document.documentElement).getPropertyValue(name);
    pen.fillRect(0, 0, 1, 1);
    const want = pen.getImageData(0, 0, 1, 1).data;
    return row.filter(pixel => [0, 1, 2].every(k => Math.abs(pixel[k] - want[k]) < 3)).length / devicePixelRatio;
  });
}"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    from ecs_eco.config import load

    out = tmp_path_factory.mktemp("stretch") / "run"
    config = load("predator-prey", PARK | {"space.size": [60, 60]})
    run_to_folder(
        config,
        seed=3,
        ticks=TICKS,
        out=out,
        policies="random",
        record="focal=5",
        checkpoint_every=50,
        keep=9,
        snapshot_every=20,
        report=False,
    )
    return out


@pytest.fixture
def replay(browser, folder):
    """The page of a recorded run, standing still at tick 100."""
    with served("watch", str(folder)) as run, opened(browser, run.address()) as page:
        pause(page)
        seek(page, 100)
        yield page


def slider(page):
    return page.get_by_label("Time, in ticks")


def seek(page, tick):
    slider(page).evaluate(
        f"slider => {{ slider.value = {tick}; slider.dispatchEvent(new Event('input')); "
        "slider.dispatchEvent(new Event('change')) }"
    )
    until(page, f"ecs.tick === {tick} && ecs.still")


def shown(page):
    """First and last tick that the slider covers."""
    return slider(page).evaluate("slider => [Number(slider.min), Number(slider.max)]")


def choose(page, first, last):
    """Drag over a stretch with shift; return what is shown then."""
    (low, high), box = shown(page), page.locator("#timeline").bounding_box()
    one, other = (box["x"] + 4 + (tick - low) / (high - low) * (box["width"] - 8) for tick in (first, last))
    page.keyboard.down("Shift")
    page.mouse.move(one, box["y"] + 30)
    page.mouse.down()
    page.mouse.move((one + other) / 2, box["y"] + 30)
    page.mouse.move(other, box["y"] + 30)
    page.mouse.up()
    page.keyboard.up("Shift")
    return shown(page)


def test_a_stretch_is_shown_by_keys_buttons_and_wheel_and_the_whole_time_again(replay):
    page = replay
    page.locator("#canvas").focus()
    page.keyboard.press("z")
    first, last = shown(page)
    assert first < 100 < last
    assert last - first == pytest.approx((TICKS - 1) / 2, abs=1)
    page.get_by_role("button", name="A shorter period").click()
    assert shown(page)[1] - shown(page)[0] == pytest.approx((TICKS - 1) / 4, abs=1)
    assert page.evaluate("ecs.tick") == 100
    page.keyboard.press("Shift+Z")
    assert shown(page)[1] - shown(page)[0] == pytest.approx((TICKS - 1) / 2, abs=2)
    page.get_by_role("button", name="The whole period").click()
    assert shown(page) == [0, TICKS - 1]
    box = page.locator("#timeline").bounding_box()
    page.mouse.move(box["x"] + box["width"] - 6, box["y"] + 30)
    page.mouse.wheel(0, -400)
    until(page, "document.querySelector('#timeline input').min > 60")
    assert shown(page)[1] == pytest.approx(TICKS - 1, abs=3)  # what is below the pointer stays there
    page.mouse.wheel(-box["width"] / 2, 0)
    until(page, f"document.querySelector('#timeline input').max < {TICKS - 10}")
    page.locator("#canvas").focus()
    page.keyboard.press("0")
    assert shown(page) == [0, TICKS - 1]


def test_a_stretch_is_chosen_by_dragging_with_shift_and_goes_with_time(replay):
    page = replay
    first, last = choose(page, 90, 130)
    assert (first, last) == pytest.approx((90, 130), abs=3)
    assert page.evaluate("ecs.tick") == 100  # the slider has stayed
    assert f"of {first} to {last}" in slider(page).get_attribute("aria-valuetext")
    slider(page).focus()
    page.keyboard.press("End")  # the slider's own end is that of the stretch
    until(page, f"ecs.tick === {last} && ecs.still")
    page.locator("#step").click()
    until(
        page,
        f"ecs.tick === {last + 1} && ecs.still && document.querySelector('#timeline input').max > {last}",
    )
    assert shown(page)[1] - shown(page)[0] == last - first
    assert shown(page)[0] < last + 1 < shown(page)[1]


def test_a_recorded_stretch_is_played_again_and_again(replay):
    page = replay
    first, last = choose(page, 90, 115)
    page.get_by_role("button", name="Repeat").click()
    assert page.locator("#loop").get_attribute("aria-pressed") == "true"
    assert f"Repeating ticks {first} to {last}" in page.locator("#loop").get_attribute("title")
    play(page)
    for _ in range(2):
        until(page, f"ecs.tick > {(first + last) // 2}")
        until(page, f"ecs.tick < {(first + last) // 2}")
    assert page.evaluate("ecs.tick") >= first
    page.locator("#canvas").focus()
    page.keyboard.press("r")
    assert page.locator("#loop").get_attribute("aria-pressed") == "false"
    until(page, f"ecs.tick > {last + 10}")
    pause(page)


def test_a_recorded_run_begins_anew_at_its_end_however_fast_it_plays(replay):
    page = replay
    page.locator("#canvas").focus()
    page.keyboard.press("r")
    page.locator("#speed").fill("10")
    page.evaluate("""() => {
      let last = ecs.tick;
      window.turns = 0;
      setInterval(() => { if (ecs.tick < last) window.turns += 1; last = ecs.tick; }, 5);
    }""")
    play(page)
    # at such a speed a page that is slow sees few of the ticks; at the end it stands until it is back
    until(page, "window.turns > 2 && ecs.playing")
    pause(page)


def test_what_was_recorded_in_detail_and_what_was_filled_in_is_told(replay):
    page, panel = replay, replay.locator("#organism")
    about = page.locator("#timelineAbout")
    recorded = f"Details (at most 5 focal organisms per species) of deer, wolf: ticks 0 to {TICKS - 1}."
    assert about.inner_text() == recorded
    assert slider(page).get_attribute("aria-describedby") == "timelineAbout"
    focal = page.locator("#timeline canvas").evaluate(PIXELS)
    select(page, "grass")
    panel.get_by_role("button", name="Fill in").click()
    until(page, "document.querySelector('#timelineAbout').textContent.includes('Filled in')")
    assert about.inner_text().startswith(f"{recorded} Filled in: ticks ")
    filled = page.locator("#timeline canvas").evaluate(PIXELS)
    assert focal[0] > 100  # a bar over the whole width
    assert 10 < filled[1] < focal[0] / 1.5
    box = page.locator("#timeline").bounding_box()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 30)  # tick 120
    until(page, "document.querySelector('#timeline input').title.includes('Filled in')")
    assert recorded[:-1] in slider(page).get_attribute("title")
    page.keyboard.press("Escape")


def test_a_living_world_lives_a_stretch_again_and_again(page):
    play(page)
    until(page, "ecs.tick >= 60")
    pause(page)
    first, last = choose(page, 15, 45)
    page.locator("#canvas").focus()
    page.keyboard.press("r")
    play(page)
    for _ in range(2):
        until(page, f"ecs.tick < {(first + last) // 2}")
        until(page, f"ecs.tick > {(first + last) // 2}")
    pause(page)
    assert page.evaluate("ecs.tick") <= last + 1
    page.keyboard.press("r")
    page.keyboard.press("0")
    assert shown(page)[0] == 0


def test_a_run_that_is_recorded_cannot_be_played_again_and_says_why(browser, tmp_path):
    words = ["run", "predator-prey", *SMALL, "--ticks", "100000", "--no-report", "--watch"]
    with served(*words, "--out", str(tmp_path / "run")) as run, opened(browser, run.address()) as page:
        assert page.locator("#loop").is_disabled()
        assert "its records cannot be undone" in page.locator("#loop").get_attribute("title")
        page.locator("#canvas").focus()
        page.keyboard.press("r")
        assert page.locator("#loop").get_attribute("aria-pressed") == "false"


@pytest.mark.parametrize("size", [PHONE, {"width": 844, "height": 390}, {"width": 640, "height": 400}])
def test_a_phone_has_the_buttons_and_room_for_the_timeline(page, size):
    page.set_viewport_size(size)
    for name in ("shorter", "longer", "whole", "loop"):
        box = page.locator(f"#{name}").bounding_box()
        assert box["x"] + box["width"] <= size["width"], name
        assert box["y"] + box["height"] <= size["height"], name
        assert min(box["width"], box["height"]) >= 24, name
    assert page.locator("#timeline").bounding_box()["width"] > 60
