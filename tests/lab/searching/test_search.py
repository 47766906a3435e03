"""A search from its first candidate to its report, on a world whose fate is known: mites without food starve
when their store is burnt."""

from __future__ import annotations

import json
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.lab import search
from ecs_eco.lab.searching.evaluate import Job, evaluate
from ecs_eco.lab.searching.plan import plan_of
from ecs_eco.lab.work import Work

WORLD = """\
# mites live for energy / basal seconds
format = 1
name = "fell"
ticks = 100
[space]
size = [20.0, 20.0]
[species.mite]
count = 4                                   # four
body = { radius = 0.1 }
metabolism = { energy = { value = 0.5, search = [0.1, 1.0] }, energy_max = 1.0, basal = 0.02 }
lethal = [{ property = "energy", min = 0.0, low = "starved" }]
[search]
world_seeds = 2
finalists = 2
confirm = { world_seeds = 3 }
[search.ranges]
"species.mite.metabolism.basal" = { search = [0.002, 0.04], scale = "log" }
"""
BASAL, ENERGY = "species.mite.metabolism.basal", "species.mite.metabolism.energy"


@pytest.fixture
def world(tmp_path: Path) -> Path:
    path = tmp_path / "fell.toml"
    path.write_text(WORLD, encoding="utf-8")
    return path


def job(world: Path, values: dict[str, float], least: list[float], **more: Any) -> Job:
    plan = replace(plan_of(load(world)), **more)
    return Job("c", plan, values, least, world.parent / "policies")


# one candidate


def test_a_run_ends_at_the_first_extinction_and_dying_later_is_better(world: Path) -> None:
    early, late = (evaluate(job(world, {BASAL: b, ENERGY: 0.5}, [], stages=[(100, 1)])) for b in (0.05, 0.01))
    assert [e["stages"][0]["runs"][0]["extinct"] for e in (early, late)] == ["mite", "mite"]
    lived = [e["stages"][0]["runs"][0]["lived"] for e in (early, late)]
    assert lived[0] == pytest.approx(10, abs=1)
    assert lived[1] == pytest.approx(50, abs=1)
    assert early["score"] == lived[0] / 100


def test_who_lives_to_the_end_scores_more_than_anyone_who_dies(world: Path) -> None:
    outcome = evaluate(job(world, {BASAL: 0.001}, []))
    assert [s["lost"] for s in outcome["stages"]] == [0, 0, 0]
    assert outcome["score"] == pytest.approx(2.0)  # all its time, and nobody fewer than the mean


def test_who_outlives_the_run_without_births_does_not_persist(world: Path) -> None:
    """Mites that divide from an energy on that none of them has, and others that can."""
    path = world.parent / "old.toml"
    path.write_text(
        WORLD.replace(
            "[search]",
            """[species.mite.reproduction]
kind = "asexual"
rate = 0.2
energy_min = 0.4
energy_given = 0.01

[search]""",
        ),
        encoding="utf-8",
    )
    barren, breeding = (
        evaluate(job(path, {BASAL: 0.002, ENERGY: energy}, [], stages=[(20, 1), (100, 1)]))
        for energy in (0.3, 1.0)
    )
    assert [s["lost"] for s in barren["stages"]] == [0, 1]  # in the first stage it is too early to tell
    (run,) = barren["stages"][1]["runs"]
    assert (run["extinct"], run["lived"], run["score"]) == ("mite, without births", 0, 0.0)
    assert [s["lost"] for s in breeding["stages"]] == [0, 0]


def test_a_candidate_without_hope_is_given_up_at_once(world: Path) -> None:
    outcome = evaluate(job(world, {BASAL: 0.04}, []))  # dead at 13 of the first 25 ticks
    assert (outcome["stage"], [s["ticks"] for s in outcome["stages"]], len(outcome["stages"][0]["runs"])) == (
        0,
        [25],
        1,
    )


def test_a_candidate_worse_than_asked_for_goes_no_further(world: Path) -> None:
    assert evaluate(job(world, {BASAL: 0.001}, [2.1, -1.0]))["stage"] == 0
    assert evaluate(job(world, {BASAL: 0.001}, [1.9, 2.1]))["stage"] == 1
    assert evaluate(job(world, {BASAL: 0.001}, [1.9, 1.9]))["stage"] == 2


def test_the_same_numbers_and_seeds_give_the_same_outcome_whatever_was_asked_for(world: Path) -> None:
    whole, first = (evaluate(job(world, {BASAL: 0.006}, least)) for least in ([-1.0, -1.0], [9.0, 9.0]))
    outcomes = [
        [{k: v for k, v in r.items() if k != "seconds"} for r in f["stages"][0]["runs"]]
        for f in (whole, first)
    ]
    assert outcomes[0] == outcomes[1]


def test_numbers_that_make_no_world_are_a_candidate_without_worth(world: Path) -> None:
    outcome = evaluate(job(world, {ENERGY: 3.0}, []))
    assert outcome["score"] == 0
    assert "energy" in outcome["refused"]


def explode(series: Any) -> float:
    raise ZeroDivisionError("no hope")


def test_what_an_objective_raises_is_kept(world: Path) -> None:
    config = load(world, {"search.objective": explode})
    outcome = evaluate(job(world, {BASAL: 0.001}, [], config=config))
    assert outcome["failed"] == "ZeroDivisionError: no hope"


# a whole search


@pytest.mark.slow
def test_a_search_finds_a_world_that_lives_and_confirms_it_on_seeds_of_its_own(
    world: Path, tmp_path: Path
) -> None:
    result = search(world, tmp_path / "out", trials=25, workers=1)
    assert result["candidates"] == 25
    best = result["best"][0]["values"]
    assert best[ENERGY] / best[BASAL] > 100
    confirmed = result["confirmation"]
    assert (confirmed["best"]["persisted"], confirmed["best"]["runs"], confirmed["start"]["persisted"]) == (
        3,
        3,
        0,
    )
    assert min(w for _, w in confirmed["cells"]) > max(w for _, w in result["cells"])
    for name in (
        "search.html",
        "search.json",
        "figures/survival.svg",
        "figures/history.svg",
        "figures/importance.svg",
        "figures/dependence.svg",
        "figures/pairs.svg",
    ):
        assert (tmp_path / "out" / name).stat().st_size > 1000
    page = (tmp_path / "out" / "search.html").read_text(encoding="utf-8")
    opening = page[page.index("<div class='verdict'>") : page.index("<h2>")]
    assert "On fresh seeds, all species persist" in opening
    # 3 of 3 and 0 of 3 (Wilson: 0.4385 to 1, 0 to 0.5615): 1 − √2 · 0.5615
    assert "in 0 of 3 runs: a difference of 1 (0.206 to 1)." in opening
    assert f"The best world has {BASAL} = " in opening
    assert f", {ENERGY} = " in opening
    assert "(0.5 as written)." in opening


def test_the_best_worlds_are_files_that_say_what_was_found(world: Path, tmp_path: Path) -> None:
    result = search(world, tmp_path / "out", ["species.mite.count=6"], trials=8, workers=1, report=False)
    for rank, best in enumerate(result["best"], 1):
        path = tmp_path / "out" / f"best-{rank}.toml"
        config = load(path)
        assert config.species["mite"].count == 6
        assert config.species["mite"].metabolism.basal == best["values"][BASAL]
        assert config.species["mite"].metabolism.energy == best["values"][ENERGY]
        assert "# four" in path.read_text(encoding="utf-8")
        assert set(config.search.ranges) == {BASAL, ENERGY}


@pytest.mark.slow
def test_a_search_that_was_stopped_goes_on_as_if_it_had_not_been(world: Path, tmp_path: Path) -> None:
    def stop(s: Any) -> None:
        if s.done == 13:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        search(world, tmp_path / "a", trials=16, workers=1, progress=stop)
    assert len((tmp_path / "a" / "journal.jsonl").read_text().splitlines()) == 14
    again = search(world, tmp_path / "a", trials=16, workers=1, report=False)
    once = search(world, tmp_path / "b", trials=16, workers=1, report=False)
    assert again["best"] == once["best"]
    journal = tmp_path / "a" / "journal.jsonl"
    before = journal.read_bytes()
    assert search(world, tmp_path / "a", trials=16, workers=1, report=False)["candidates"] == 16
    assert journal.read_bytes() == before  # nothing is done twice
    entries = [json.loads(line) for line in before.splitlines()]
    cells = [tuple(e["cell"]) for e in entries if e["kind"] == "confirmation"]
    assert sorted(set(cells)) == [(100_001, 100_001), (100_001, 100_002), (100_001, 100_003)]
    assert all(("cell" in e) == (e["kind"] == "confirmation") for e in entries)
    assert [len(e["stages"][0]["runs"]) for e in entries if e["kind"] == "final"] == [2, 2]


@pytest.mark.slow
def test_results_are_equal_whatever_worker_finishes_first(
    world: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    arrived = Work.arrived

    def last_first(work: Work[Any], timeout: float | None = None) -> list[Any]:
        found = arrived(work, timeout)
        while len(work):
            found += arrived(work, timeout)
        return found[::-1]

    def results(out: Path) -> tuple[dict[str, Any], list[Any]]:
        search(world, out, trials=6, workers=1, report=False)
        written = json.loads((out / "search.json").read_text())
        for key in [key for key in written if "seconds" in key or "cpu" in key]:
            del written[key]
        written["best_so_far"] = [merit for _, merit in written["best_so_far"]]
        entries = [json.loads(line) for line in (out / "journal.jsonl").read_text().splitlines()]
        return written, [e["cell"] for e in entries if e["kind"] == "confirmation"]

    once, cells = results(tmp_path / "a")
    monkeypatch.setattr(Work, "arrived", last_first)
    again, reversed_cells = results(tmp_path / "b")
    assert cells != reversed_cells
    assert once == again


@pytest.mark.slow
def test_a_budget_of_time_ends_a_search(world: Path, tmp_path: Path) -> None:
    result = search(world, tmp_path / "out", budget=0.03, workers=1, report=False)
    assert result["candidates"] >= 1
    assert result["seconds"] < 10


def test_an_objective_that_fails_for_the_world_as_written_ends_the_search(
    world: Path, tmp_path: Path
) -> None:
    values = {"search.objective": explode, BASAL: 0.003, f'search.ranges."{BASAL}"': [0.002, 0.04]}
    with pytest.raises(ConfigError, match="ZeroDivisionError: no hope"):
        search(world, tmp_path / "out", values, trials=3, workers=1)


# the command


@pytest.mark.slow
def test_the_command_searches_with_processes_and_goes_on(world: Path, tmp_path: Path) -> None:
    command = [
        "search",
        str(world),
        "--trials",
        "2",
        "--out",
        str(tmp_path / "out"),
        "--ticks",
        "60",
        "--quiet",
    ]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    assert "best-1.toml" in done.output
    assert tomllib.loads((tmp_path / "out" / "best-1.toml").read_text(encoding="utf-8"))["name"] == "fell"
    assert json.loads((tmp_path / "out" / "search.json").read_text(encoding="utf-8"))["candidates"] == 2
    refused = CliRunner().invoke(app, [*command, "--seed", "9"])
    assert refused.exit_code == 2
    assert "search.seed: 1 then, 9 now" in refused.output


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--range", f"{BASAL}=0.5"], ["--range", "KEY=LOW:HIGH"]),
        (["--range", f"{BASAL}=0.5:a"], ["--range", "KEY=LOW:HIGH"]),
        (["--range", f"{BASAL}=0.001:0.1:lag"], ["unknown scale", 'did you mean "log"']),
        (["--range", f"{BASAL}=0.5:0.6"], ["--range", "does not contain the world's value, 0.02"]),
        (["--range", "species.mite.metabolism.basl=0:1"], ["--range", 'did you mean "basal"']),
        (["--objective", "persistense"], ["search.objective", 'did you mean "persistence"']),
        (["--objective", "no.such:thing"], ["search.objective", "`code` does not list"]),
        (["--policies", "train"], ["search.policies", "no species has a policy to train"]),
        (["--optimiser", "tpee"], ["--optimiser", 'did you mean "tpe"']),
        (
            ["--set", f"{BASAL}=0.01", "--set", f"{ENERGY}=0.6", "--trials", "2"],
            ["nothing to vary", "--range"],
        ),
    ],
)
def test_wrong_arguments_are_refused_before_anything_is_made(
    world: Path, tmp_path: Path, arguments: list[str], words: list[str]
) -> None:
    done = CliRunner().invoke(app, ["search", str(world), "--out", str(tmp_path / "out"), *arguments])
    assert done.exit_code == 2
    assert [word for word in words if word not in done.output] == [], done.output
    assert not (tmp_path / "out").exists()
