"""The map of an archipelago: numbers on islands, migrants along ways, islands at a click."""

import json
import re
from contextlib import contextmanager

import pytest

from ecs_eco.config import load
from ecs_eco.lab import Archipelago
from ecs_eco.testing.browser import launched, served, until
from ecs_eco.view.islands import Map, Opened, describe
from tests.lab.newts import written
from tests.view.pages import IN_A_BROWSER, violations


def made(folder):
    """Newts on three islands in a ring, at tick 8 of 12: two barriers passed, migrants at the first."""
    islands = Archipelago.from_config(load(str(written(folder))), seed=2, out=folder / "run")
    islands.run(until=8, report=False)
    return islands


def test_the_map_says_who_is_where_and_who_moved(tmp_path):
    islands = made(tmp_path)
    told = describe(islands.folder)
    assert [island["name"] for island in told["islands"]] == ["north", "east", "south"]
    assert told["islands"][1]["own"] == "species.newt.count = 40"
    assert sorted(map(tuple, told["ways"])) == [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)]
    assert told["points"] == list(range(8))
    now = [state["n"]["newt"] for state in islands.manifest["islands"].values()]
    assert [numbers[0][-1] for numbers in told["n"]] == now
    assert {point for point, *_ in told["moves"]} == {4}  # the barrier before the fifth tick
    assert 0 < sum(number for *_, number in told["moves"]) < 65


def test_an_archipelago_that_has_not_begun_has_a_map_without_numbers(tmp_path):
    islands = Archipelago.from_config(load(str(written(tmp_path))), seed=2, out=tmp_path / "run")
    told = describe(islands.folder)
    assert told["n"] == told["points"] == told["moves"] == []
    assert len(told["islands"]) == 3


class Notes:
    """A page that notes what it gets."""

    def __init__(self):
        self.got = []

    def send(self, messages):
        self.got += map(json.loads, messages)


def test_an_island_that_is_none_is_refused_with_the_nearest_name(tmp_path):
    shown, page = Map(made(tmp_path).folder), Notes()
    for request in ({"kind": "join"}, {"kind": "open", "island": "nort"}, {"kind": "seek"}):
        shown.say(page, request)
    shown.say(None, {"kind": "leave"})
    shown._wake.wait = lambda seconds: shown.close()
    shown.run()
    assert [message["kind"] for message in page.got] == ["islands", "said", "said"]
    assert "expected north, east, south; did you mean 'north'?" in page.got[1]["text"]


@pytest.mark.slow
def test_the_process_of_an_island_takes_no_modules_of_the_folder_that_it_runs_in(tmp_path, monkeypatch):
    for name in ("ecs_eco", "json", "pydantic"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'mark')!r}, 'w')\n")
    monkeypatch.chdir(tmp_path)
    said = []
    Opened(tmp_path)._ask("nowhere", 1, lambda address, why: said.append(why))
    assert "nowhere" in said[0]
    assert "is not a run folder" in said[0]  # it came as far as that
    assert not (tmp_path / "mark").exists()


@pytest.fixture(scope="module")
def browser():
    with launched() as browser:
        yield browser


@contextmanager
def opened(browser, islands):
    """The map of a run in a browser."""
    with served("watch", str(islands.folder)) as run:
        context = browser.new_context(viewport={"width": 1200, "height": 760})
        context.set_default_timeout(180_000)
        page, problems = context.new_page(), []
        page.on("pageerror", lambda error: problems.append(str(error)))
        page.goto(run.address())
        until(page, "ecs.maps > 0 && ecs.connected")
        page.islands = islands
        yield page
        assert problems == []
        context.close()


@pytest.fixture(scope="module")
def page(browser, tmp_path_factory):
    """The map of a run at tick 8, which no test lets go on."""
    with opened(browser, made(tmp_path_factory.mktemp("islands"))) as page:
        yield page


def numbers(page):
    """What the map says of each island."""
    said = page.locator(".island").evaluate_all("all => all.map(one => one.getAttribute('aria-label'))")
    return [int(re.search(r"(\d+) newt", words)[1]) for words in said]


def browsed(test):
    """A test that needs a browser."""
    for mark in IN_A_BROWSER:
        test = mark(test)
    return test


@browsed
def test_time_goes_back_and_forth_over_the_map(page):
    first = [20, 40, 5]
    page.get_by_role("slider", name="Time").fill("0")
    until(page, "ecs.tick === 0")
    assert sum(numbers(page)) >= sum(first) - 5  # at the end of the first tick
    assert page.locator(".way-count").count() == 0
    page.get_by_role("slider", name="Time").fill("7")
    until(page, "ecs.tick === 7")
    assert numbers(page) != first
    told = describe(page.islands.folder)
    counts = page.locator(".way-count").all_text_contents()
    assert sum(map(int, counts)) == sum(number for *_, number in told["moves"])


@browsed
@pytest.mark.parametrize("size", [(390, 844), (844, 390), (320, 568)])
def test_the_map_is_legible_and_whole_on_phones(page, size):
    before = page.viewport_size
    page.set_viewport_size({"width": size[0], "height": size[1]})
    heights = "[...document.querySelectorAll('#map text')].map(one => one.getBoundingClientRect().height)"
    until(page, f"innerWidth === {size[0]} && Math.min(...{heights}) >= 10", 60)
    edge = page.locator("#map").bounding_box()
    texts = page.locator("#map text")
    boxes = texts.evaluate_all("all => all.map(one => one.getBoundingClientRect().toJSON())")
    assert min(box["left"] for box in boxes) >= edge["x"] - 1
    assert max(box["right"] for box in boxes) <= edge["x"] + edge["width"] + 1
    assert max(box["bottom"] for box in boxes) <= edge["y"] + edge["height"] + 1
    page.set_viewport_size(before)


@browsed
def test_the_map_is_accessible_in_both_themes(page):
    for _ in range(2):
        assert violations(page) == []
        page.locator("#theme").click()


@browsed
def test_a_click_opens_an_island_and_its_page_leads_back_to_the_map(page):
    here = page.url
    page.locator("[data-island=east] .shore").click()
    page.wait_for_url(lambda url: url != here)
    until(page, "ecs.frames > 0 && ecs.mode === 'replay'")
    newts = describe(page.islands.folder)["n"][1][0][-1]
    assert page.evaluate("ecs.tick") == 0
    assert page.locator("#title").inner_text().startswith("east, ")
    page.locator("#play").click()
    until(page, f"ecs.tick === 7 && ecs.counts.newt === {newts}")
    page.get_by_role("link", name="map").click()
    page.wait_for_url(here)
    until(page, "ecs.maps > 0 && ecs.connected")


@browsed
def test_the_map_follows_a_run_to_its_next_barrier(browser, tmp_path):
    islands = made(tmp_path)
    with opened(browser, islands) as page:
        until(page, "ecs.tick === 7")
        islands.run(until=12, report=False)
        until(page, "ecs.tick === 11")
        assert numbers(page) == [state["n"]["newt"] for state in islands.manifest["islands"].values()]
        assert "done" in page.locator("#state").inner_text()
