"""What happens is told as it happens, with its cause, and the page says why."""

import pytest

from ecs_eco.testing.browser import served, until
from tests.view.pages import IN_A_BROWSER, PARK, SMALL, opened, pause, play, select
from tests.view.test_page_time import go

pytestmark = IN_A_BROWSER
END = "species.wolf.lethal.1.max=400"  # [s]: all wolves die of age at tick 400, after the page was opened
FASTEST = "it => { it.value = it.max; it.dispatchEvent(new Event('input')) }"

LANES = """() => {  // the colors at the left edge of the timeline
  const pen = document.createElement('canvas').getContext('2d', {willReadFrequently: true});
  pen.drawImage(document.querySelector('#timeline canvas'), 0, 0);
  const { data } = pen.getImageData(1, 0, 1, 100);
  return Array.from({length: 100}, (_, y) => '#' + [0, 1, 2].map((k) => data[4 * y + k].toString(16).padStart(2, '0')).join(''));
}"""  # noqa: E501


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
    assert page.evaluate(wolf).lower() in page.evaluate(LANES)
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
    assert any(why in said for why in ("its policy", "did nothing", "always tries"))


def test_scenes_of_a_story_follow_each_other_in_time(page):
    scenes = """([events, first, last]) => import('/tour.js').then(({ scenes }) => scenes(
      events.map(([tick, kind]) => ({ tick, kind })), first, last).map(({ from, to, entry }) => [from, to, entry?.tick ?? null]))"""  # noqa: E501
    events = [[25, "birth"], [35, "crash"], [65, "crash"], [161, "extinct"], [179, "extinct"]]
    told = page.evaluate(scenes, [events, 0, 699])
    assert told[:3] == [[0, 10, None], [10, 30, 25], [30, 45, 35]]  # half of the way to the event after
    assert told[3:] == [[45, 75, 65], [131, 170, 161], [170, 189, 179], [689, 699, None]]
    many = [[10 * tick, "crash"] for tick in range(1, 20)] + [[200, "extinct"]]
    assert [tick for *_, tick in page.evaluate(scenes, [many, 0, 300])][-2:] == [200, None]
    assert len(page.evaluate(scenes, [many, 0, 300])) == 12  # 5 s each


def test_the_story_of_a_recorded_run_is_played(browser, tmp_path):
    from ecs_eco.config import load
    from ecs_eco.record import run_to_folder

    config = load("predator-prey", PARK | {"space.size": [60, 60], "species.wolf.lethal.1.max": 40})
    run_to_folder(config, seed=3, ticks=60, out=tmp_path / "run", policies="random", report=False)
    with served("watch", str(tmp_path / "run")) as run, opened(browser, run.address()) as page:
        page.locator("#tab-why").click()
        page.locator(".story li.extinct").wait_for()
        notice = "document.querySelector('#notice').textContent"
        far = page.evaluate("ecs.camera[2]")
        page.get_by_role("button", name="Play the story").click()
        until(page, f"{notice}.includes(' grass, 80 deer, 12 wolf.')")
        until(page, f"ecs.playing && {notice}.includes('Wolf died out. Deaths since')")
        until(page, f"ecs.camera[2] < {far / 2} && ecs.tick < 40")
        until(page, "ecs.counts.wolf === 0 && ecs.tick >= 40")
        page.locator("#notice").get_by_role("button", name="Stop").click()
        until(page, "!ecs.playing && ecs.still")
        assert page.locator("#playStory").get_attribute("aria-pressed") == "false"
        assert "10 ticks/s" in page.locator("#speedText").inner_text()  # as before
        page.get_by_role("button", name="Play the story").click()
        until(page, f"ecs.playing && {notice}.includes(' grass, 80 deer, 12 wolf.')")
        go(page, 55)  # the user drags the timeline: the story must not go on elsewhere
        until(page, "ecs.tick === 55 && !ecs.playing && ecs.still")
        assert page.locator("#playStory").get_attribute("aria-pressed") == "false"
        page.locator("#notice").wait_for(state="hidden")
