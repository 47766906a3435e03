"""The timeline: labelled, with lanes; a living world goes back in time, and goes on."""

import pytest

from ecs_eco.testing.browser import served, until
from tests.view.pages import IN_A_BROWSER, opened, pause, play

pytestmark = IN_A_BROWSER
CHARTED = "Number(document.querySelector('#tick').textContent.replace(/\\D/g, ''))"


@pytest.fixture
def later(page):
    """The page of a living world at tick 60 or later, standing still."""
    play(page)
    until(page, "ecs.tick >= 60")
    pause(page)
    return page


def go(page, tick):
    """Let the slider of time go at a tick."""
    page.get_by_label("Time, in ticks").evaluate(
        "(slider, tick) => { slider.value = tick; slider.dispatchEvent(new Event('input')); "
        "slider.dispatchEvent(new Event('change')) }",
        tick,
    )


def test_a_living_world_goes_back_and_comes_to_the_same_again(later):
    page = later
    tick = page.evaluate("ecs.tick")
    uid = page.evaluate("ecs.uids('wolf')[0]")
    then = page.evaluate(f"ecs.place({uid})")
    go(page, 20)
    until(page, f"ecs.tick === 20 && ecs.still && {CHARTED} === 20")
    assert page.evaluate(f"ecs.place({uid})") != then
    page.locator("#canvas").focus()
    for _ in range((tick - 20) // 10):
        page.keyboard.press("Shift+Period")
    for _ in range((tick - 20) % 10):
        page.keyboard.press("Period")
    until(page, f"ecs.tick === {tick} && ecs.still")
    assert page.evaluate(f"ecs.place({uid})") == pytest.approx(then, abs=1e-6)


def test_one_tick_back(later):
    page = later
    tick = page.evaluate("ecs.tick")
    page.locator("#back").click()
    until(page, f"ecs.tick === {tick - 1} && ecs.still")
    page.locator("#canvas").focus()
    page.keyboard.press(",")
    until(page, f"ecs.tick === {tick - 2} && ecs.still")


def test_a_living_world_does_not_go_where_it_has_not_been(later):
    page = later
    tick = page.evaluate("ecs.tick")
    go(page, tick + 30)
    until(page, f"ecs.tick === {tick} && ecs.still")
    assert page.get_by_label("Time, in ticks").evaluate("slider => Number(slider.max)") > tick


def test_the_label_of_an_extinction_is_not_hidden_by_a_crash(page):
    labels = """([events, width]) => import('/timeline.js').then(({ foremost, labels }) =>
      labels(foremost(events), width, (text) => 5 * text.length).map(({ text, left }) => [text, left]))"""
    crash, end = (
        {"x": x, "name": f"deer {kind}", "kind": kind} for x, kind in ((50, "crash"), (60, "extinct"))
    )
    assert page.evaluate(labels, [[crash, end], 300]) == [["deer extinct", 57]]
    wolf, boom = (
        {"x": 100, "name": "wolf extinct", "kind": "extinct"},
        {"x": 150, "name": "boom", "kind": "boom"},
    )
    both = [["deer, wolf extinct", 57]]  # 5 px per letter: until 147
    assert page.evaluate(labels, [[crash, end, wolf, boom], 300]) == both
    boom["x"] = 160
    assert page.evaluate(labels, [[crash, end, wolf, boom], 300]) == [*both, ["boom", 157]]
    assert page.evaluate(labels, [[crash, end, wolf], 120]) == [["deer, wolf extinct", 30]]  # inside the row


def test_each_of_seven_species_has_a_lane(browser, tmp_path):
    lines = ['format = 1\nname = "seven"\nspace = { size = [20.0, 20.0], edges = "walls" }']
    lines += [f"[species.s{i}]\ncount = 3\nbody = {{ radius = 0.1 }}" for i in range(7)]
    (tmp_path / "seven.toml").write_text("\n".join(lines))
    lanes = """document.querySelector('#timeline canvas').checkVisibility() && (() => {
      const canvas = document.querySelector('#timeline canvas');
      const copy = Object.assign(document.createElement('canvas'), {width: canvas.width, height: canvas.height});
      const pen = copy.getContext('2d', {willReadFrequently: true});
      pen.drawImage(canvas, 0, 0);
      const column = [...Array(copy.height).keys()].map(y => pen.getImageData(1, y, 1, 1).data[3] > 200);
      return column.filter((full, y) => full && !column[y - 1]).length;
    })()"""
    with (
        served("watch", str(tmp_path / "seven.toml"), "--seed", "1") as run,
        opened(browser, run.address()) as page,
    ):
        play(page)
        until(page, "ecs.tick > 10")
        pause(page)
        until(page, f"{lanes} === 7", 10)
