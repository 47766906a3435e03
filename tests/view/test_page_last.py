"""The panel of one that dies while it is selected: its last state, and of what it died."""

from ecs_eco.config import load
from ecs_eco.record import run_to_folder
from ecs_eco.record.parquet import read_parts
from ecs_eco.testing.browser import served, until
from tests.view.pages import IN_A_BROWSER, PARK, opened, pause, select
from tests.view.test_page_time import go

pytestmark = IN_A_BROWSER
READINGS = """[...document.querySelectorAll('#organism .nerves text')].map(text => text.textContent).join()"""


def test_one_that_dies_keeps_what_it_felt_and_did_in_its_last_tick(page):
    pause(page)
    uid, panel = select(page, "deer"), page.locator("#organism")
    page.locator("#step").click()
    panel.locator(".nerves").wait_for()
    assert "past" not in panel.get_attribute("class").split()
    page.locator("#tab-act").click()
    page.get_by_role("button", name="Remove the selected organism").click()
    until(page, "document.querySelectorAll('#act .log li').length > 0")
    tick = page.evaluate("ecs.tick")
    page.locator("#step").click()
    until(
        page,
        "document.querySelector('#organism .state.dead') && "
        "document.querySelector('#organism .died').textContent.includes('removed')",
    )
    page.locator("#tab-organism").click()
    assert f"#{uid}" in panel.locator(".who").inner_text()
    assert f"in its last tick, {tick}" in panel.locator("h2").first.inner_text()
    assert f"last tick, {tick}." in panel.locator(".note").inner_text()
    assert panel.get_by_role("button", name="Fill in").count() == 0
    grey = "getComputedStyle(document.querySelector('#organism .nerves')).filter"
    assert page.evaluate(grey) == "grayscale(1)"
    last = page.evaluate(READINGS)
    page.locator("#step").click()
    until(page, f"ecs.tick === {tick + 2} && ecs.still")
    assert page.evaluate(READINGS) == last
    select(page, "deer")
    until(page, "!document.querySelector('#organism').classList.contains('past')")


def test_in_a_replay_one_that_dies_keeps_its_last_tick_until_time_goes_back(browser, tmp_path):
    cull = {"at": 12, "kind": "cull", "species": "wolf", "share": 0.5}
    config = load("predator-prey", PARK | {"space.size": [60, 60], "interventions": [cull]})
    run_to_folder(config, 3, 30, tmp_path / "run", "random", record="full", report=False)
    deaths = read_parts(tmp_path / "run" / "deaths").to_pylist()
    death = next(row for row in deaths if row["species"] == "wolf")
    with served("watch", str(tmp_path / "run")) as run, opened(browser, run.address()) as page:
        until(page, "!ecs.playing && ecs.still")
        page.evaluate(f"location.hash = 'tick=11&uid={death['uid']}&tab=organism'")
        panel, head = page.locator("#organism"), "document.querySelector('#organism .part h2').innerText"
        until(
            page,
            "document.querySelector('#organism .state')?.innerText === 'alive' "
            f"&& {head} === 'Nervous system'",
        )
        until(page, "!document.querySelector('[data-eye=follow]').disabled")
        go(page, 12)
        until(page, "document.querySelector('#organism .state.dead') !== null")
        assert page.evaluate(head) == "Nervous system in its last tick, 12"
        last = page.evaluate(READINGS)
        go(page, 25)
        until(page, "ecs.tick === 25 && ecs.still")
        assert page.evaluate(READINGS) == last
        assert "culled, tick 12" in panel.locator(".died").inner_text()
        assert panel.get_by_role("button", name="Fill in").count() == 0
        assert panel.get_by_role("button", name="Follow").is_disabled()
        go(page, 8)
        until(
            page,
            f"document.querySelector('#organism .state')?.innerText === 'alive' && {head} === "
            "'Nervous system' && !document.querySelector('#organism').classList.contains('past')",
        )
        assert page.evaluate(READINGS) != last
