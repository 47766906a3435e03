"""Another seed, or another world, chosen in the page: at the same address, for all pages."""

import re

from ecs_eco.testing.browser import served, until
from tests.view.pages import IN_A_BROWSER, SMALL, opened, pause

pytestmark = IN_A_BROWSER


def begin(page, world, seed):
    page.locator("#tab-world").click()
    page.get_by_label("World to start").select_option(world)
    page.get_by_label("Seed").fill(seed)
    page.get_by_role("button", name="Start", exact=True).click()


def shown(page, title, seed):
    """Wait until the page shows this world, and has drawn it: it is loaded anew."""
    page.locator("#title", has_text=title).wait_for()
    page.locator("#world dd", has_text=re.compile(f"^{seed}$")).wait_for(state="attached")
    until(page, "ecs.frames > 0 && ecs.renders > 0 && ecs.connected")


def test_a_world_is_begun_anew_with_another_seed_and_then_another_one(browser):
    with served("watch", "predator-prey", *SMALL) as run, opened(browser, run.address()) as page:
        address = page.url
        with opened(browser, run.address()) as other:
            pause(page)
            begin(page, "predator-prey", "11")
            for one in (page, other):
                shown(one, "Grass, deer and wolves", "11")
            assert page.evaluate("ecs.counts.wolf") == 12  # as the command set it
        begin(page, "reflexes", "")
        shown(page, "Goats", "1")
        assert page.url == address
        until(page, "ecs.playing && ecs.tick > 2")
        page.locator("#tab-world").click()
        assert page.get_by_label("World to start").input_value() == "reflexes"


def test_a_recorded_run_says_why_there_is_nothing_to_choose(browser, tmp_path):
    from ecs_eco.config import load
    from ecs_eco.record import run_to_folder

    small = {"species.grass.count": 300, "species.deer.count": 60, "species.wolf.count": 12}
    run_to_folder(load("predator-prey", small), 5, 4, tmp_path / "run", "random", report=False)
    with served("watch", str(tmp_path / "run")) as run, opened(browser, run.address()) as page:
        page.locator("#tab-world").click()
        page.get_by_text("This is a recorded run.").wait_for()
        assert page.get_by_label("World to start").count() == 0
