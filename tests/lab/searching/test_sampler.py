"""Searches that sample: posteriors of a model whose answer is known, and a search from prior to page."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ecs_eco.analysis.runs import Series
from ecs_eco.config import load
from ecs_eco.config.measurements import Outside
from ecs_eco.engine.errors import ConfigError, ForeignFile
from ecs_eco.lab import search
from ecs_eco.lab.searching.evaluate import likeness
from ecs_eco.lab.searching.figures import posterior_pairs, scatter
from ecs_eco.lab.searching.journal import Journal
from ecs_eco.lab.searching.plan import Fit, Plan, plan_of, sampled, statistics
from ecs_eco.lab.searching.report import posterior_blocks, posterior_opening, write_world
from ecs_eco.lab.searching.sampler import Population, Sampler, summary, weighted_quantiles
from tests.analysis.test_against import waves

COUNT, BASAL = "species.mite.count", "species.mite.metabolism.basal"
WORLD = """\
format = 1
name = "fell"
ticks = 30
[space]
size = [20.0, 20.0]
[species.mite]
count = { value = 40, search = [10, 200] }
body = { radius = 0.1 }
metabolism.energy = 1.0
metabolism.energy_max = 1.0
metabolism.basal = { value = 0.01, search = [0.001, 0.1], scale = "log" }
reproduction = { kind = "asexual", place = "anywhere", rate = 0.02, energy_min = 0.1, energy_given = 0.05 }
[data]
file = "mites.csv"
ticks = 1.0
statistics = ["mean"]
[search]
objective = "data"
posterior = { particles = 10 }
"""


@pytest.fixture
def world(tmp_path: Path) -> Path:
    path = tmp_path / "fell.toml"
    path.write_text(WORLD, encoding="utf-8")
    (tmp_path / "mites.csv").write_text("day,mite\n" + "".join(f"{i},{100 + i % 3}\n" for i in range(20)))
    return path


def sampler_of(world: Path, kind: str, **posterior: Any) -> Sampler:
    plan = plan_of(load(world, {f"search.posterior.{k}": v for k, v in posterior.items()})).sampling()
    return Sampler(plan, kind, Journal(world.parent / kind, plan.header()))


def simulate(sampler: Sampler, numbers: range, seed: int = 0) -> None:
    """A model in place of worlds: the statistic is where the count lies in its range, and noise of .05."""
    rng = np.random.default_rng(seed)
    for n in numbers:
        assert sampler.ready(n)
        if sampler.finished(n):
            return
        values = sampler.ask(n)
        place = (values[COUNT] - 10) / 190
        own = {"mean mite": place + rng.normal(0, 0.05)} if values[COUNT] < 190 else None
        sampler.journal.entries.append(
            {
                "kind": "candidate",
                "candidate": n,
                "values": values,
                "stages": [{"runs": [{"statistics": own}]}],
            }
        )


def observing(sampler: Sampler, value: float) -> Sampler:
    sampler.fit.observed["mean mite"] = value
    return sampler


@pytest.mark.parametrize(("kind", "n", "wide"), [("abc", 1000, 0.26), ("abc-smc", 800, 0.22)])
def test_the_posterior_is_that_of_a_model_whose_answer_is_known(
    world: Path, kind: str, n: int, wide: float
) -> None:
    """A normal of width .05 around .4: its 90 % interval is .318 to .482; the other number stays unknown."""
    sampler = observing(sampler_of(world, kind, particles=200), 0.4)
    simulate(sampler, range(1, n + 1))
    kept = sampler.posterior()
    low, middle, high = weighted_quantiles(kept.at[:, 0], kept.weights, [0.05, 0.5, 0.95])
    assert middle == pytest.approx(0.4, abs=0.025)
    assert 0.13 < high - low < wide
    low, high = weighted_quantiles(kept.at[:, 1], kept.weights, [0.05, 0.95])
    assert high - low > 0.75
    assert (np.diff(kept.distances) >= 0).all()
    told = summary(sampler, kept, {e["candidate"]: e for e in sampler.journal.entries})
    assert told["numbers"][COUNT]["low"] < 10 + 0.4 * 190 < told["numbers"][COUNT]["high"]


@pytest.mark.parametrize(("observed", "place"), [(0.4, ""), (3.0, "above"), (-2.0, "below")])
def test_a_measured_value_that_the_posterior_does_not_predict_is_flagged(
    world: Path, tmp_path: Path, observed: float, place: str
) -> None:
    sampler = observing(sampler_of(world, "abc", particles=60), observed)
    simulate(sampler, range(1, 200))
    told = summary(sampler, sampler.posterior(), {e["candidate"]: e for e in sampler.journal.entries})
    said = "".join(posterior_blocks(sampler, told, tmp_path / "figures"))
    assert ("does not predict mean mite" in posterior_opening(told)[1]) == bool(place)
    assert (f">{place}</td>" in said) or not place


def test_dots_at_the_ends_of_the_ranges_are_drawn_whole(world: Path) -> None:
    parameters, one = sampler_of(world, "abc").plan.parameters, np.ones(2)
    kept = Population(np.arange(2), np.array([[0.0, 1.0], [1.0, 0.5]]), one, one)
    (ax,) = [ax for ax in posterior_pairs(parameters, kept).axes if ax.collections]
    (dots,) = ax.collections
    assert sorted(dots.get_offsets()[:, 0]) == [parameters[0].low, parameters[0].high] == [*ax.get_xlim()]
    assert not dots.get_clip_on()
    entries = [{"values": {p.name: p.low for p in parameters}}]
    values = {p.name: p.high for p in parameters}
    for ax in scatter(parameters, entries, np.ones(1), values, values).axes:
        assert not any(dots.get_clip_on() for dots in ax.collections)


def test_the_narrowest_parameters_open_the_page() -> None:
    ends = {"median": 5.0, "low": 4.0, "high": 6.0}
    wide, narrow = ends | {"range": [3.0, 7.0]}, ends | {"range": [0.0, 20.0]}
    known = {"numbers": {"a": wide, "b": narrow}, "statistics": {"mean mite": ends | {"observed": 4.0}}}
    assert posterior_opening(known) == [
        "Median and central 90% of the posterior: b = 5 (4 to 6), a = 5 (4 to 6).",
        "It predicts mean mite.",
    ]
    assert posterior_opening({"numbers": {}, "statistics": {}}) == []


def test_weights_undo_that_later_generations_are_drawn_elsewhere(world: Path) -> None:
    """Without weights, numbers near the edge of a flat posterior are drawn too rarely."""
    sampler = observing(sampler_of(world, "abc-smc", particles=400, stop=0.0), 0.4)
    for n in range(1, 2001):
        sampler.journal.entries.append(
            {
                "kind": "candidate",
                "candidate": n,
                "values": sampler.ask(n),
                "stages": [{"runs": [{"statistics": {"mean mite": 0.4 + n % 7}}]}],
            }
        )
    kept = sampler.posterior()
    assert kept.shares @ kept.at == pytest.approx([0.5, 0.5], abs=0.09)
    assert np.sqrt(kept.shares @ (kept.at - 0.5) ** 2) == pytest.approx([12**-0.5] * 2, abs=0.04)


def test_a_proposal_follows_from_the_seed_and_the_journal(world: Path) -> None:
    a, b = (sampler_of(world, "abc-smc", particles=20) for _ in range(2))
    simulate(a, range(1, 26))
    b.journal.entries += a.journal.entries
    assert b.ask(26) == a.ask(26)
    del b.journal.entries[3]
    assert not sampler_of(world, "abc-smc", particles=20).ready(21)
    assert not Sampler(b.plan, "abc-smc", b.journal).ready(21)
    assert len({a.cell(n) for n in range(1, 50)}) == 49


def test_it_ends_when_new_candidates_are_no_nearer(world: Path) -> None:
    sampler = observing(sampler_of(world, "abc-smc", particles=40, stop=0.2), 0.4)
    simulate(sampler, range(1, 5000))
    assert 40 < len(sampler.journal.entries) < 2000


def test_quantiles_of_equal_weights_are_those_of_weibull() -> None:
    found = weighted_quantiles(np.arange(1.0, 20.0), np.ones(19), [0.05, 0.5, 0.95])
    assert found == pytest.approx([1, 10, 19])


# what is compared


def outside(ticks: float | None) -> Outside:
    return Outside(np.arange(24.0), {"hare": waves(24, 8.0), "lynx": waves(24, 8.0, 0.2)}, {}, "year", ticks)


@pytest.mark.parametrize("ticks", [10.0, None])
def test_runs_are_sampled_as_the_measurements_are(ticks: float | None) -> None:
    n = np.stack([waves(600, 80.0), waves(600, 80.0, 0.2)], 1)
    run = Series(np.arange(600), ("hare", "lynx"), {"n": n})
    kinds = ("period", "lag", "amplitude")
    of = outside(ticks)
    x = sampled(run, of)
    assert x is not None
    assert x.shape == (24, 2)
    own = statistics(x, ["hare", "lynx"], of, kinds)
    assert ("period" in own) == (ticks is not None)
    fit = Fit(of, kinds, statistics(np.stack(list(of.columns.values()), 1), ["hare", "lynx"], of, kinds), "")
    assert np.abs(fit.differences(own)).max() < 0.05
    assert likeness(run, fit) > 0.7
    assert likeness(Series(run.ticks[:100], run.species, {"n": n[:100]}), fit) == 0
    around = {name: value + (0.97 if name.startswith("lag") else 0) for name, value in fit.observed.items()}
    assert np.abs(fit.differences(around)).max() == pytest.approx(0.03)


# whole searches


@pytest.mark.slow
def test_a_search_that_samples_writes_a_posterior_and_goes_on(world: Path, tmp_path: Path) -> None:
    options: dict[str, Any] = {"optimiser": "abc-smc", "workers": 1}
    first = search(world, tmp_path / "s", trials=8, report=False, **options)
    assert first["posterior"]["kept"] == 5
    result = search(world, tmp_path / "s", trials=16, **options)
    whole = search(world, tmp_path / "whole", trials=16, report=False, **options)
    assert result["posterior"] == whole["posterior"]
    assert result["candidates"] == 16
    rows = list(csv.DictReader((tmp_path / "s" / "posterior.csv").read_text().splitlines()))
    assert sum(float(row["weight"]) for row in rows) == pytest.approx(1)
    assert float(rows[0]["distance"]) <= float(rows[-1]["distance"])
    assert set(rows[0]) == {"candidate", "generation", "weight", "distance", COUNT, BASAL, "mean mite"}
    page = (tmp_path / "s" / "search.html").read_text()
    lines = [json.loads(line) for line in (tmp_path / "s" / "journal.jsonl").read_text().splitlines()]
    reached = [e["stage"] for e in lines if e.get("stage") == len(result["stages"]) - 1 and "candidate" in e]
    assert f"; {len(reached)} reached the last stage." in page
    assert "<h2>Posterior</h2>" in page
    assert page.count('class="plot') >= 2
    assert (tmp_path / "s" / "figures" / "posterior-pairs.svg").is_file()
    near = load(tmp_path / "s" / "best-1.toml")
    assert near.file(near.data.file).is_file()
    assert json.loads((tmp_path / "s" / "search.json").read_text())["optimiser"] == "abc-smc"


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"search.objective": "persistence"}, 'and [search] objective = "data"'),
        ({"search.ticks": 15}, "is shorter than the measurements"),
        ({"data.statistics": ["lag"]}, "leaves nothing to compare"),
        ({"data.columns": {"mite": "mites"}}, 'did you mean "mite"?'),
    ],
)
def test_what_cannot_be_fitted_is_refused(
    world: Path, tmp_path: Path, changes: dict[str, Any], fault: str
) -> None:
    with pytest.raises(ConfigError) as error:
        search(world, tmp_path / "s", changes, trials=3, optimiser="abc")
    assert fault in str(error.value)


def test_a_goal_needs_measurements(world: Path) -> None:
    world.write_text(WORLD.replace('[data]\nfile = "mites.csv"\nticks = 1.0\nstatistics = ["mean"]\n', ""))
    with pytest.raises(ConfigError, match="is missing: the objective of"):
        load(world)


def test_other_measurements_make_another_search(world: Path, tmp_path: Path) -> None:
    search(world, tmp_path / "s", trials=3, optimiser="abc", workers=1, report=False)
    (tmp_path / "mites.csv").write_text("day,mite\n" + "".join(f"{i},{50 + i % 3}\n" for i in range(20)))
    with pytest.raises(ForeignFile, match="is another search"):
        search(world, tmp_path / "s", trials=3, optimiser="abc", workers=1, report=False)


def test_plans_of_other_searches_are_as_they_were(world: Path) -> None:
    plan: Plan = plan_of(load(world, {"search.objective": "persistence"}))
    assert "data" not in plan.header()
    assert "posterior" in plan_of(load(world)).header()["search"]
    assert (
        "posterior"
        not in plan_of(
            load("predator-prey", {"search.ranges": {"species.wolf.reproduction.rate": [0.004, 0.02]}})
        ).header()["search"]
    )


def test_best_worlds_keep_the_raster_that_they_name(world: Path, tmp_path: Path) -> None:
    grid = "ncols 4\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 5\n" + "1 2 3 4\n" * 4
    (tmp_path / "land").mkdir()
    (tmp_path / "land" / "dem.asc").write_text(grid)
    (tmp_path / "land" / "dem.prj").write_text("")
    land = 'edges = "walls"\n[terrain]\nraster = "land/dem.asc"\ncell = 5.0\n[species.mite]'
    world.write_text(WORLD.replace("[species.mite]", land, 1))
    search(
        world,
        tmp_path / "out" / "s",
        {"search.objective": "persistence"},
        trials=2,
        workers=1,
        optimiser="random",
        report=False,
    )
    assert (tmp_path / "out" / "s" / "land" / "dem.prj").is_file()
    for folder in ("land/dem.asc", "mites.csv"):
        (tmp_path / folder).unlink()
    assert load(tmp_path / "out" / "s" / "best-1.toml")._land.elevation.max() == 4


@pytest.mark.parametrize("kind", ["beside", "above", "absolute"])
def test_worlds_are_written_with_their_measurements_wherever_these_are(
    world: Path, tmp_path: Path, kind: str
) -> None:
    names = {"beside": "mites.csv", "above": "../fell.csv", "absolute": str(tmp_path / "mites.csv")}
    (tmp_path.parent / "fell.csv").write_text((tmp_path / "mites.csv").read_text())
    world.write_text(world.read_text().replace('"mites.csv"', f'"{names[kind]}"'))
    (tmp_path / "s").mkdir()
    plan, file = plan_of(load(world)), tmp_path / "s" / "best-1.toml"
    for source in (world, load(world)):
        write_world(plan, source, {}, {COUNT: 50}, tmp_path, file, "the best")
        near = load(file)
        assert near.species["mite"].count == 50
        assert near.file(near.data.file).read_text() == (tmp_path / "mites.csv").read_text()
    assert (tmp_path / "s" / "mites.csv").exists() == (kind == "beside")
