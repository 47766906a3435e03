"""Runs that are recorded: what is clicked is in them, and they are watched again."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.testing.browser import entered, served, until
from ecs_eco.view.guard import SUBPROTOCOL
from tests.view.pages import IN_A_BROWSER, SMALL, opened, pause, play, select

pytestmark = IN_A_BROWSER


def test_the_page_says_when_the_run_has_ended(browser):
    with (
        served("watch", "predator-prey", *SMALL, "--ticks", "2") as run,
        opened(browser, run.address()) as page,
    ):
        page.locator("#play").click()
        until(page, "ecs.tick === 2 && !document.querySelector('#notice').hidden")
        assert "has ended" in page.locator("#notice").inner_text()
        run.process.terminate()
        until(page, "ecs.ended")


def test_each_reporter_has_a_chart_of_its_own(browser):
    asked = 'reporters={ "mean energy" = "mean(Metabolism.energy)", ratio = "count(wolf) / count(deer)" }'
    with (
        served("watch", "predator-prey", *SMALL, "--set", asked, "--ticks", "30") as run,
        opened(browser, run.address()) as page,
    ):
        play(page)
        until(page, "ecs.tick > 5 && document.querySelectorAll('#charts .chart').length >= 5")
        charts = page.locator("#charts .chart")
        assert charts.locator("h2").all_inner_texts()[3:5] == ["mean energy", "ratio"]
        value = "document.querySelectorAll('#charts .chart')[4].querySelector('b').textContent"
        until(page, f"{value} === '0.15'")  # 12 wolves, 80 deer
        assert "the world" in charts.nth(4).inner_text()
        assert "wolf" in charts.nth(3).inner_text()
        run.process.terminate()


def test_a_page_goes_on_with_another_address_after_the_server_was_started_again(browser):
    with served("watch", "predator-prey", *SMALL) as run:
        first = run.address()
        port = first.split(":")[2].split("/")[0]
        context = browser.new_context()
        page = context.new_page()
        page.goto(first)
        until(page, "ecs.frames > 0 && ecs.connected")
    with served("watch", "predator-prey", *SMALL, "--port", port) as run:
        address = run.address()
        until(page, "ecs.refused")
        assert "has restarted" in page.locator("#notice").inner_text()
        page.get_by_label("Address shown in the terminal").fill(address)
        page.get_by_role("button", name="Open").click()
        until(page, "ecs.connected && ecs.frames > 0")
        context.close()


@pytest.fixture(scope="module")
def recorded(browser, tmp_path_factory):
    """A run that is recorded, stopped as by Ctrl-C; meanwhile somebody clicks: its folder, the manifest,
    and what the page said."""
    from websockets.sync.client import connect

    out = tmp_path_factory.mktemp("page") / "run"
    words = [
        "run",
        "predator-prey",
        *SMALL,
        "--ticks",
        "20000",
        "--checkpoint-every",
        "50",
        "--no-report",
        "--out",
        str(out),
        "--watch",
    ]
    with served(*words) as run:
        host, credential = entered(run.address())
        with connect(
            f"ws://{host}/ws", origin=f"http://{host}", subprotocols=[SUBPROTOCOL, credential], max_size=None
        ) as hasty:
            hasty.send('{"kind": "pause"}')  # before too much has passed
            while (
                isinstance(heard := hasty.recv(180), bytes) or json.loads(heard).get("playing") is not False
            ):
                pass
        with opened(browser, run.address()) as page:
            output = _clicked(page)
            run.process.terminate()
            until(page, "ecs.ended")
        run.process.wait(180)
    return out, json.loads((out / "manifest.json").read_text()), output


def step(page, ticks):
    """Let so many tens of ticks pass, by the keyboard; return the tick then."""
    goal = page.evaluate("ecs.tick") + ticks
    page.locator("#canvas").focus()
    for _ in range(ticks // 10):
        page.keyboard.press("Shift+Period")
    until(page, f"ecs.tick === {goal} && ecs.still")
    return goal


def seek(page, tick):
    page.get_by_label("Time, in ticks").evaluate(
        f"slider => {{ slider.value = {tick}; slider.dispatchEvent(new Event('input')) }}"
    )
    until(
        page,
        f"ecs.tick === {tick} && ecs.still && "
        f"document.querySelector('#tick').textContent.replace(/\\D/g, '') === '{tick}'",
    )


def _clicked(page):
    """Place, remove and cull by the mouse, a tick between; return what the page's log says,
    first to last, and who was removed."""
    pause(page)
    tick = step(page, 30)
    removed = select(page, "deer")
    page.locator("#tab-act").click()
    page.get_by_role("button", name="Remove the selected organism").click()
    until(page, "document.querySelectorAll('#act .log li').length === 1")
    page.locator("#step").click()
    until(
        page,
        f"ecs.tick === {tick + 1} && ecs.still && document.querySelector('#organism "
        ".died')?.textContent.includes('removed')",
    )
    assert removed not in page.evaluate("ecs.uids('deer', 10000)")
    page.get_by_label("Kind to place").select_option("wolf")
    page.get_by_label("How many").fill("7")
    page.get_by_role("button", name="Click in the scene").click()
    page.mouse.click(*np.mean(page.evaluate("ecs.corners()"), axis=0))  # the middle of the world
    page.get_by_label("Kind to cull").select_option("deer")
    page.get_by_role("button", name="Cull").click()
    until(page, "document.querySelectorAll('#act .log li').length === 3")
    page.locator("#step").click()
    until(page, f"ecs.tick === {tick + 2} && ecs.counts.wolf === 19 && ecs.counts.deer < 70")
    step(page, 20)
    log = page.locator("#act .log li").all_inner_texts()[::-1]
    return {"tick": tick, "log": log, "removed": removed, "counts": page.evaluate("ecs.counts")}


def test_what_is_clicked_is_recorded_and_comes_out_the_same_again(recorded):
    out, manifest, output = recorded
    tick = output["tick"]
    assert [when for when, _ in manifest["intervened"]] == [tick, tick + 1, tick + 1]
    remove, add, cull = (what for _, what in manifest["intervened"])
    assert (remove["kind"], remove["uids"], remove["cause"]) == ("cull", [output["removed"]], "removed")
    assert (add["kind"], add["species"], add["count"]) == ("add", "wolf", 7)
    assert add["at_place"] == pytest.approx([30, 30], abs=3)  # where it was clicked: the middle
    assert (cull["kind"], cull["species"], cull["share"]) == ("cull", "deer", 0.2)
    assert [line.split()[0] for line in output["log"][:2]] == [str(tick), str(tick + 1)]
    assert "cull 20% of deer" in output["log"][2]
    assert manifest["done"] == tick + 22
    result = CliRunner().invoke(app, ["repeat", str(out), "--quiet"])
    assert result.exit_code == 0, result.output
    assert "the same result" in result.output
    assert manifest["digest"][:12] in result.output


def test_a_recorded_run_is_scrubbed_and_what_was_not_recorded_is_filled_in(browser, recorded):
    out, manifest, output = recorded
    with served("watch", str(out)) as run, opened(browser, run.address()) as page:
        assert page.evaluate("ecs.mode") == "replay"
        assert not page.locator("#tab-act").is_visible()
        assert page.evaluate("[ecs.tick, ecs.playing]") == [0, False]  # it waits for Play
        assert page.locator("#rate").inner_text() == "press Play"
        seek(page, manifest["done"] - 1)
        until(page, "document.querySelector('#rate').textContent === 'the end'")
        page.locator("#play").click()  # from the beginning
        until(page, "ecs.playing && ecs.tick < 30")
        pause(page)
        seek(page, 3)
        chart = page.locator("#charts .u-over").first
        chart.click(position={"x": chart.bounding_box()["width"] / 2, "y": 20})  # to its middle
        until(page, f"Math.abs(ecs.tick - {manifest['done'] / 2}) < 4 && ecs.still")
        seek(page, 3)
        page.locator("#play").click()
        until(page, "ecs.tick > 5")
        pause(page)
        for tick, counts in (
            (manifest["done"] - 1, output["counts"]),
            (output["tick"] - 1, {"deer": 80, "wolf": 12}),
            (10, {"deer": 80}),
        ):
            seek(page, tick)
            assert page.evaluate("ecs.counts").items() >= counts.items()  # as the page saw it live
        uid, panel = select(page, "deer"), page.locator("#organism")
        panel.locator(".note").wait_for()
        assert f"#{uid}" in panel.locator(".who").inner_text()
        assert panel.locator(".nerves").count() == 0
        panel.get_by_role("button", name="Fill in").click()
        panel.locator(".nerves").wait_for()
