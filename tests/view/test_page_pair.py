"""What if: the world twice on one page, as it was and with a change; and two worlds beside each other."""

import io
from xml.etree import ElementTree

import pytest

from ecs_eco.testing.browser import served, until
from tests.view.pages import IN_A_BROWSER, PHONE, SMALL, WIDE, opened, pause, play, violations
from tests.view.test_page_access import CONTRAST
from tests.view.test_page_capture import DRAWN, saved, words_of
from tests.view.test_page_time import go

pytestmark = IN_A_BROWSER
WALL = "document.querySelector('#stage').classList.contains('alone')"


@pytest.fixture
def standing(page):
    """The page of a living world at tick 20 or later, standing still, without a second world at its end."""
    if page.evaluate("ecs.tick") < 20:
        play(page)
        until(page, "ecs.tick >= 20")
    pause(page)
    yield page
    page.keyboard.press("Escape")
    if page.evaluate("ecs.second !== null"):
        page.locator("#pairClose").click()
        until(page, "ecs.second === null")


@pytest.fixture
def forked(standing):
    """The same, with a second world in which there are no wolves."""
    standing.locator("#whatif").click()
    standing.get_by_role("button", name="without wolf").click()
    until(standing, "ecs.second && ecs.second.frames > 0 && ecs.second.still")
    return standing


def steps(page, ticks):
    """Let so many ticks pass."""
    tick = page.evaluate("ecs.tick")
    page.locator("#canvas").focus()
    for _ in range(ticks):
        page.keyboard.press("Period")
    until(
        page, f"ecs.tick === {tick + ticks} && ecs.still && ecs.second?.tick === ecs.tick && ecs.second.still"
    )


def test_pairs_with_other_seeds_run_in_the_background(standing):
    page, tick = standing, standing.evaluate("ecs.tick")
    page.locator("#whatif").click()
    page.get_by_text("fewer", exact=True).click()
    page.locator("#ask").get_by_label("Kind to reduce").select_option("wolf")
    page.locator("#ask").get_by_label("Share to cull, in percent").fill("100")
    page.get_by_label("Number of pairs").fill("2")
    page.get_by_label("Last tick of the pairs").fill(str(tick + 3))
    page.get_by_role("button", name="Run pairs").click()
    page.locator(".pairs progress").wait_for()
    assert "0 of 4 runs" in page.locator(".pairs").inner_text()
    page.locator(".pairs li").first.wait_for()
    assert "With it: All species persisted in 0 of 2 runs" in page.locator(".pairs").inner_text()
    assert f"--seeds 2 --ticks {tick + 3}" in page.locator(".pairs pre").inner_text()
    until(page, "document.querySelector('.pairs img').naturalWidth > 300")
    page.get_by_text("a value", exact=True).click()  # the dialog opens with the last choice
    page.get_by_role("button", name="Cancel").click()


def test_without_wolves_the_world_goes_on_beside_the_one_with_wolves(forked):
    page, tick = forked, forked.evaluate("ecs.tick")
    assert not page.locator("#ask").is_visible()
    steps(page, 3)
    assert page.evaluate("[ecs.counts.wolf, ecs.second.counts.wolf]") == [12, 0]
    assert page.evaluate("ecs.counts.deer === ecs.second.counts.deer")
    until(page, "document.querySelector('#pairSays').innerText.includes('12 alive in the original')")
    assert f"wolf died out at tick {tick} here" in page.locator("#pairSays").inner_text()
    assert f"from tick {tick} onward: cull 100% of wolf" in page.locator("#pairWhat").inner_text()
    row = page.locator(".legend-row", has_text="wolf")
    assert row.locator("b").all_inner_texts() == ["12", "0"]
    assert row.locator("b.differs").count() == 1
    left, sign, name, right = (
        row.locator(part).bounding_box()
        for part in ("b:not(.other)", ":scope > svg:first-child", ".named", "b.other")
    )
    assert left["x"] + left["width"] <= sign["x"] < sign["x"] + sign["width"] <= name["x"]
    assert name["x"] + name["width"] <= right["x"]
    until(
        page,
        "[...document.querySelectorAll('#charts .chart-head')].some((head) => "
        "/wolf\\s*12 \\| 0/.test(head.innerText))",
    )
    page.locator("#tab-why").click()
    assert "what if: cull 100% of wolf" in page.locator("#why").inner_text()


def test_a_picture_shows_both_worlds_with_their_names_and_counts(forked):
    from matplotlib.image import imread

    page = forked
    steps(page, 1)
    page.locator("[data-eye=top]").click()
    until(page, "ecs.still && ecs.second.still")
    page.evaluate(DRAWN)
    _, data = saved(page, page.get_by_role("button", name="Picture", exact=True).click)
    drawing = ElementTree.fromstring(page.evaluate("drawn"))
    counts, there = page.evaluate("[ecs.counts, ecs.second.counts]")
    assert words_of(drawing)[1:4] == [
        f"{counts[kind]} and {there[kind]} {kind}" for kind in ("grass", "deer", "wolf")
    ]
    about = drawing.find(".//{http://www.w3.org/2000/svg}tspan")
    assert about.text == page.locator("#pairWhat").inner_text()
    assert there["wolf"] == 0 < counts["wolf"]
    picture = imread(io.BytesIO(data))
    assert picture.shape[1] == 2008
    brown = (picture[..., 0] > picture[..., 2] + 0.2) & (picture[..., 0] < 0.7)  # deer, as many in both
    left, right = brown[:, :1004].mean(), brown[:, 1004:].mean()
    assert left > 0.001
    assert right == pytest.approx(left, rel=0.5)


def test_bodies_look_alike_however_full_each_world_is(page):
    least = """import('/stage.js').then(({ Stage }) => {
      const of = n => ({ kind: { moves: true }, block: { n }, own: { least: { value: 0 } } });
      const stage = n => Object.assign(Object.create(Stage.prototype), {
        canvas: { clientWidth: 600, clientHeight: 400 }, layers: [of(n)], peer: null, shared: { lens: {} },
        renderer: { setPixelRatio() {}, setSize() {} }, eye: { resize() {}, camera: { fov: 40 } } });
      const [few, many] = [stage(60), stage(6000)];
      const sizes = () => [few, many].map(one => (one.resize(), one.layers[0].own.least.value));
      const apart = sizes();
      [few.peer, many.peer] = [many, few];
      return [apart, sizes()];
    })"""
    apart, beside = page.evaluate(least)
    assert apart[0] > apart[1]
    assert beside == [apart[1]] * 2


def test_both_are_looked_at_from_the_same_place(forked):
    page = forked
    first, second = page.locator("#canvas").bounding_box(), page.locator("#canvas2").bounding_box()
    assert (first["width"], first["height"]) == pytest.approx((second["width"], second["height"]), abs=1.5)
    assert second["x"] >= first["x"] + first["width"] - 1
    page.locator("[data-eye=top]").click()
    until(page, "ecs.still && ecs.second.still")
    before = page.evaluate("ecs.camera")
    assert page.evaluate("ecs.second.camera") == pytest.approx(before, rel=1e-6)
    page.mouse.move(second["x"] + 150, second["y"] + 300)
    page.mouse.wheel(0, -400)
    until(page, f"ecs.camera.join() !== '{','.join(map(str, before))}' && ecs.still && ecs.second.still")
    assert page.evaluate("ecs.camera") == pytest.approx(page.evaluate("ecs.second.camera"), rel=1e-6)
    page.locator("[data-eye=side]").click()


def test_both_go_back_in_time_and_before_the_fork_there_is_one(forked):
    page, tick = forked, forked.evaluate("ecs.tick")
    steps(page, 6)
    go(page, tick + 2)
    until(page, f"ecs.tick === {tick + 2} && ecs.second.tick === {tick + 2} && ecs.second.counts.wolf === 0")
    go(page, tick - 5)
    until(page, f"ecs.tick === {tick - 5} && {WALL}")
    until(page, f"document.querySelector('#pairSays').innerText.includes('original at tick {tick}')")
    steps(page, 8)
    assert not page.evaluate(WALL)
    assert page.evaluate("[ecs.counts.wolf, ecs.second.counts.wolf]") == [12, 0]


def test_a_change_that_does_not_fit_is_refused_in_the_dialog_and_a_kept_tick_is_forked(standing):
    page, tick = standing, standing.evaluate("ecs.tick")
    page.locator("#canvas").focus()
    page.keyboard.press("y")
    until(page, f"Number(document.querySelector('#ask [aria-label=\"From tick\"]').max) === {tick}")
    page.locator("#ask").get_by_label("Value", exact=True).fill("species.deer.metabolism.basal")
    page.locator("#ask").get_by_label("New value").fill("-1")
    page.get_by_role("button", name="Branch").click()
    problem = page.locator("#ask .problem")
    problem.wait_for()
    assert "species.deer.metabolism.basal" in problem.inner_text()
    assert page.evaluate("ecs.second") is None
    page.locator("#ask").get_by_label("New value").fill("0.5")
    page.locator("#ask").get_by_label("From tick").fill("12")
    page.get_by_role("button", name="Branch").click()
    until(page, f"ecs.second && ecs.second.tick === {tick} && ecs.second.still")
    assert (
        "from tick 12 onward: species.deer.metabolism.basal = 0.5" in page.locator("#pairWhat").inner_text()
    )
    page.locator("#pairAgain").click()
    command = page.locator("#again .recipe").first.inner_text()
    assert command.startswith("ecs-eco run predator-prey --seed 3 --policies random --set")
    assert 'interventions=[{ at = 12, kind = "set"' in command
    page.locator("#again").get_by_role("button", name="Close").click()


def test_what_is_closed_is_gone_and_the_page_is_as_before(forked):
    page = forked
    page.locator("#pairClose").click()
    until(page, "ecs.second === null")
    assert page.locator("#canvas2, #over2, .pane-name, .pair-key").count() == 0
    assert not page.locator("#pair").is_visible()
    width = page.locator("#stage").bounding_box()["width"]
    assert page.locator("#canvas").bounding_box()["width"] == pytest.approx(width, abs=1)
    assert page.locator(".legend-row b.other:visible").count() == 0


@pytest.mark.parametrize("size", [(390, 844), (844, 390)])
def test_on_phones_both_have_room_one_above_the_other_or_side_by_side(forked, size):
    page = forked
    page.set_viewport_size({"width": size[0], "height": size[1]})
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0]
    first, second = page.locator("#canvas").bounding_box(), page.locator("#canvas2").bounding_box()
    if size == tuple(PHONE.values()):
        assert second["y"] >= first["y"] + first["height"] - 1
        assert min(first["height"], second["height"]) > 200
        page.locator("#tab-charts").scroll_into_view_if_needed()
        assert page.locator("#charts").bounding_box()["height"] > 300
    else:
        assert second["x"] >= first["x"] + first["width"] - 1
        assert min(first["height"], second["height"]) > 130
    page.set_viewport_size(WIDE)


def test_all_of_it_is_accessible_and_its_words_stand_out_in_both_themes(forked):
    page = forked
    for opens in (None, "#pairAgain", "#whatif"):
        if opens:
            page.locator(opens).click()
        for _ in range(2):
            page.locator("#theme").evaluate("button => button.click()")
            assert violations(page) == []
            assert page.evaluate(CONTRAST) == []
        page.keyboard.press("Escape")


def test_two_worlds_stand_beside_each_other_from_the_beginning(browser):
    words = ("watch", "happiness", "lamb", "--policies", "random", "--seed", "3")
    with served(*words) as run, opened(browser, run.address()) as page:
        until(page, "ecs.second && ecs.second.frames > 0")
        pause(page)
        until(page, "ecs.second.tick === ecs.tick")
        names = page.locator(".pane-name").all_inner_texts()
        assert len(names) == 2
        assert page.locator("#pairWhat").inner_text() == " and ".join(names)
        assert "lamb" in page.evaluate("Object.keys(ecs.second.counts)")
        assert not page.locator("#pairAgain").is_visible()


def test_a_recorded_run_is_forked_where_it_stands(browser, tmp_path):
    from ecs_eco.config import load
    from ecs_eco.record import run_to_folder

    changes = dict(word.split("=", 1) for word in SMALL[1 : SMALL.index("--policies") : 2])
    run_to_folder(
        load("predator-prey", [f"{key}={value}" for key, value in changes.items()]),
        3,
        30,
        tmp_path / "run",
        "random",
        report=False,
    )
    with served("watch", str(tmp_path / "run")) as run, opened(browser, run.address()) as page:
        until(page, "!ecs.playing && ecs.still")  # a click on pause might come at its end
        go(page, 12)
        until(page, "ecs.tick === 12 && ecs.still")
        page.locator("#whatif").click()
        page.get_by_role("button", name="without wolf").click()
        until(page, "ecs.second && ecs.second.frames > 0")
        go(page, 20)
        until(page, "ecs.tick === 20 && ecs.second.tick === 21 && ecs.second.still")
        assert page.evaluate("[ecs.counts.wolf, ecs.second.counts.wolf]") == [12, 0]
        assert page.evaluate("ecs.counts.deer === ecs.second.counts.deer")
        page.locator("#pairAgain").click()
        assert "ecs-eco resume" in page.locator("#again .recipe").first.inner_text()
