"""The parts of a search, each alone: the plan, scores, the journal, the optimiser, what mattered."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ecs_eco.analysis.runs import Series
from ecs_eco.config import load
from ecs_eco.config.models.search import Search as Settings
from ecs_eco.engine.errors import ConfigError, ForeignFile, RecordingError
from ecs_eco.lab.searching import evaluate
from ecs_eco.lab.searching.journal import Journal, Planned, begin
from ecs_eco.lab.searching.optimise import FIRST, Optimiser, importances, merit, ranks, space_of
from ecs_eco.lab.searching.plan import Parameter, crossed, plan_of, stages
from ecs_eco.lab.searching.report import confirmation
from ecs_eco.record import container

PARAMETERS = [
    Parameter("rate", 0.01, 1.0, log=True, whole=False, start=0.1),
    Parameter("count", 1, 40, log=False, whole=True, start=9),
]


def test_a_journal_on_a_full_disk_says_what_is_kept_and_how_to_go_on(tmp_path: Path) -> None:
    journal = Journal(tmp_path, {"world": "fell"})
    journal.add("candidate", candidate=0)
    journal.path.unlink()
    journal.path.symlink_to("/dev/full")
    with pytest.raises(
        RecordingError,
        match=f"No space left on device; 1 evaluations are saved; free some disk space, .* --out {tmp_path}",
    ):
        journal.add("candidate", candidate=1)
    assert len(journal.entries) == 1


def test_a_journal_without_evaluations_is_not_written_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (path := Journal(tmp_path, {"world": "fell"}).path).read_text()
    monkeypatch.setattr(Path, "write_text", lambda *_, **__: pytest.fail("emptied"))
    Journal(tmp_path, {"world": "fell"})
    assert path.read_text() == text


def series(**numbers: list[float]) -> Series:
    n = np.array(list(numbers.values()), float).T
    return Series(np.arange(len(n)), tuple(numbers), {"n": n})


# the plan


def test_training_and_world_seeds_are_crossed_and_the_first_runs_differ_in_both() -> None:
    assert crossed(2, 3, 0) == ((1, 1), (2, 2), (1, 2), (2, 3), (1, 3), (2, 1))
    assert sorted(crossed(3, 2, 100)) == [(100 + t, 100 + w) for t in (1, 2, 3) for w in (1, 2)]


def test_stages_grow_by_equal_factors_in_length_and_in_runs() -> None:
    assert stages(1600, 9, 3, 0.25) == ((400, 1), (800, 3), (1600, 9))
    assert stages(1600, 9, 1, 0.25) == ((1600, 9),)


def test_seeds_of_search_finals_and_confirmation_are_apart() -> None:
    plan = plan_of(
        load("predator-prey", {'search.ranges."species.deer.count"': [100, 900], "search.policies": "train"})
    )
    kinds = [set(plan.cells), set(plan.finals), set(plan.confirmation)]
    assert all(a.isdisjoint(b) for i, a in enumerate(kinds) for b in kinds[:i])
    for axis in (0, 1):
        assert {c[axis] for c in plan.cells}.isdisjoint({c[axis] for c in plan.confirmation})


def test_a_search_without_ranges_is_refused() -> None:
    with pytest.raises(ConfigError, match="nothing to vary"):
        plan_of(load("predator-prey"))


def test_a_range_with_an_end_that_no_world_can_have_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"gives an invalid world: species\.deer\.reproduction\.energy_min"):
        plan_of(load("predator-prey", {'search.ranges."species.deer.reproduction.energy_min"': [0.5, 40.0]}))


def test_values_are_tidied_within_their_range() -> None:
    assert PARAMETERS[0].tidy(0.123456) == 0.1235
    assert (PARAMETERS[0].tidy(3.0), PARAMETERS[1].tidy(7.4)) == (1.0, 7)
    assert isinstance(PARAMETERS[1].tidy(7.4), int)


# scores


def test_the_distance_from_extinction_is_that_of_the_species_nearest_to_it() -> None:
    run = series(deer=[10, 10, 10], wolf=[8, 0, 1])  # means 10 and 3
    assert evaluate.distance(run, ["deer"]) == pytest.approx(1.0)
    assert evaluate.distance(run, ["deer", "wolf"]) == 0.0
    assert evaluate.distance(series(wolf=[8, 3, 1]), ["wolf"]) == pytest.approx(np.log(2) / np.log(5))


def test_a_wanted_population_scores_the_ratio_of_the_later_half() -> None:
    run = series(deer=[999, 999, 40, 60], wolf=[9, 9, 10, 10])
    assert evaluate.population(run, {"deer": 100.0}) == pytest.approx(0.5)
    assert evaluate.population(run, {"deer": 100.0, "wolf": 4.0}) == pytest.approx((0.5 + 0.4) / 2)


def test_cycling_tells_a_cycle_from_noise() -> None:
    rng = np.random.default_rng(1)
    t = np.arange(3000)
    cycle = 100 + 40 * np.sin(2 * np.pi * t / 150) + rng.normal(0, 5, 3000)
    assert evaluate.cycling(series(deer=list(cycle)), ["deer"]) == 1.0
    assert evaluate.cycling(series(deer=list(100 + rng.normal(0, 5, 3000))), ["deer"]) < 0.9


def final_number(run: Series) -> float:
    return float(run.n[-1].sum())


def test_goals_are_weighed_and_a_function_may_be_one() -> None:
    settings = Settings.model_validate(
        {"objective": [{"of": final_number, "weight": 3.0}, {"of": "population"}], "wanted": {"deer": 10.0}}
    )
    assert evaluate.objective(settings, series(deer=[5, 5]), ["deer"]) == pytest.approx(0.75 * 5 + 0.25 * 0.5)


def test_a_function_that_gives_no_number_scores_nothing() -> None:
    assert evaluate.score(lambda run: float("nan"), series(deer=[5]), ["deer"], {}) == 0.0


def test_a_later_stage_is_worth_more_than_any_score() -> None:
    assert merit({"stage": 0, "score": 1e6}) < merit({"stage": 1, "score": -1e6})
    assert merit({"stage": 1, "score": 0.5}) < merit({"stage": 1, "score": 0.6})
    assert merit({"stage": 0, "score": 1.0}) == 0.75


# the journal


def test_a_journal_goes_on_behind_its_last_whole_line(tmp_path: Path) -> None:
    journal = Journal(tmp_path, {"world": "fell"})
    journal.add("candidate", candidate=0, score=0.5)
    with open(journal.path, "a", encoding="utf-8") as file:
        file.write('{"kind": "candidate", "candid')
    again = Journal(tmp_path, {"world": "fell"})
    assert [e["candidate"] for e in again.of("candidate")] == [0]
    again.add("candidate", candidate=1)
    assert [json.loads(line).get("candidate") for line in journal.path.read_text().splitlines()] == [
        None,
        0,
        1,
    ]


def test_a_journal_of_another_search_is_not_gone_on_with(tmp_path: Path) -> None:
    Journal(tmp_path, {"world": "fell", "search": {"ticks": 5}}).add("candidate", candidate=0)
    with pytest.raises(ForeignFile, match=r"journal\.jsonl: belongs to another search"):
        Journal(tmp_path, {"world": "fell", "search": {"ticks": 6}})


def test_a_damaged_journal_is_refused(tmp_path: Path) -> None:
    (tmp_path / "journal.jsonl").write_text('{"kind": "search"}\nnonsense\n')
    with pytest.raises(ConfigError, match="is damaged"):
        Journal(tmp_path, {})


# the optimiser


def bowl(values: dict[str, Any]) -> float:
    """Highest, 0, at rate = .05 and count = 30."""
    return -(np.log10(values["rate"] / 0.05) ** 2) - ((values["count"] - 30) / 20) ** 2


def best_of(kind: str, seed: int, n: int = 40) -> float:
    optimiser, scores = Optimiser(PARAMETERS, kind, seed), []
    for i in range(n):
        values = optimiser.ask(i)
        assert 0.01 <= values["rate"] <= 1.0
        assert isinstance(values["count"], int)
        scores.append(bowl(values))
        optimiser.tell(i, values, scores[-1])
    return max(scores)


@pytest.mark.slow
def test_optimisers_find_the_top_of_a_bowl_better_than_chance() -> None:
    chance = np.mean([best_of("random", seed) for seed in (1, 2, 3)])
    assert np.mean([best_of("tpe", seed) for seed in (1, 2, 3)]) > chance
    assert np.mean([best_of("gp", seed, 20) for seed in (1, 2)]) > max(chance, -0.01)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["gp", "tpe", "random"])
def test_an_optimiser_that_is_told_the_history_proposes_what_the_first_would(kind: str) -> None:
    first, history = Optimiser(PARAMETERS, kind, 5), []
    for i in range(FIRST + 4):
        values = first.ask(i)
        history.append((values, bowl(values)))
        first.tell(i, *history[-1])
    again = Optimiser(PARAMETERS, kind, 5)
    for i, (values, worth) in enumerate(history):
        again.tell(i, values, worth)
    assert again.ask(99) == first.ask(99)


# importance

CUBE = [Parameter(name, 0.0, 1.0, False, False, 0.5) for name in "abc"]


def test_the_number_that_decides_is_important_and_the_others_are_not() -> None:
    rng = np.random.default_rng(2)
    x = rng.random((80, 3))
    values = [dict(zip("abc", row, strict=True)) for row in x.tolist()]
    found = importances(space_of(CUBE), values, np.sin(3 * x[:, 0]) + rng.normal(0, 0.1, 80))
    assert [*found] == ["a", "b", "c"]
    assert found["a"]["share"] > max(0.6, found["a"]["by_chance"])
    assert max(found[name]["share"] - found[name]["by_chance"] for name in "bc") < 0.05
    assert sum(of["share"] for of in found.values()) == pytest.approx(1)


def test_without_an_effect_no_number_passes_what_luck_gives() -> None:
    rng = np.random.default_rng(3)
    values = [dict(zip("abc", row, strict=True)) for row in rng.random((80, 3)).tolist()]
    found = importances(space_of(CUBE), values, rng.random(80))
    assert all(of["share"] < of["by_chance"] for of in found.values())


def test_numbers_on_a_log_scale_and_whole_ones_are_taken_as_such() -> None:
    rng = np.random.default_rng(4)
    values = [{"rate": float(10 ** rng.uniform(-2, 0)), "count": int(rng.integers(1, 41))} for _ in range(60)]
    found = importances(space_of(PARAMETERS), values, [-abs(np.log10(v["rate"] / 0.05)) for v in values])
    assert found["rate"]["share"] > max(found["count"]["share"], found["rate"]["by_chance"])


def test_ranks_share_places_among_equals() -> None:
    assert ranks([3.0, 1.0, 3.0, 9.0]).tolist() == [0.5, 0.125, 0.5, 0.875]


# the folder


PLANNED = {"world": "fell", "config_hash": "0" * 64, "search": {"ticks": 5}, "optimiser": "gp"}
STAGE = {"ticks": 5, "score": 1.0, "lost": 0, "runs": []}
ENTRY = {
    "candidate": 0,
    "values": {},
    "stage": 0,
    "score": 1.0,
    "stages": [STAGE],
    "seconds": 0.1,
    "cpu": 0.1,
    "at": 1.0,
}


def test_a_folder_belongs_to_one_search_and_one_mode(tmp_path: Path) -> None:
    begin(tmp_path, PLANNED).add("candidate", **ENTRY)
    assert [e["candidate"] for e in begin(tmp_path, PLANNED).entries] == [0]
    with pytest.raises(ForeignFile, match=r"another search: search\.ticks differs \(search\.ticks: 5 then"):
        begin(tmp_path, PLANNED | {"search": {"ticks": 6}})
    plan = container.read(tmp_path, Planned) | {"mode": "portable"}
    container.write(tmp_path, Planned, plan | {"hash": container._hash(plan, Planned)})
    with pytest.raises(ForeignFile, match="was computed in the portable mode"):
        begin(tmp_path, PLANNED)


def test_the_journal_of_another_folder_is_refused(tmp_path: Path) -> None:
    begin(tmp_path / "a", PLANNED).add("candidate", **ENTRY)
    begin(tmp_path / "b", PLANNED | {"optimiser": "tpe"})
    (tmp_path / "a" / "journal.jsonl").replace(tmp_path / "b" / "journal.jsonl")
    with pytest.raises(ForeignFile, match=r"journal\.jsonl: belongs to another search"):
        begin(tmp_path / "b", PLANNED | {"optimiser": "tpe"})


def test_an_entry_of_a_wrong_type_is_refused_by_its_line_and_key(tmp_path: Path) -> None:
    begin(tmp_path, PLANNED).add("candidate", **ENTRY | {"stages": [STAGE | {"lost": "none"}]})
    with pytest.raises(RecordingError, match=r"journal\.jsonl, line 2: stages\.0\.lost: "):
        begin(tmp_path, PLANNED)


@pytest.mark.parametrize("value", [{}, {"values": None, "cell": None}])
@pytest.mark.parametrize(("kind", "key"), [("candidate", "values"), ("confirmation", "cell")])
def test_an_entry_without_what_ran_is_refused(
    tmp_path: Path, kind: str, key: str, value: dict[str, None]
) -> None:
    entry = {k: v for k, v in ENTRY.items() if k != key}
    begin(tmp_path, PLANNED).add(kind, **entry | {k: v for k, v in value.items() if k == key})
    with pytest.raises(
        RecordingError, match=rf"journal\.jsonl, line 2: .*values or cell: is missing from this {kind}"
    ):
        begin(tmp_path, PLANNED)


def test_a_search_of_an_older_version_is_refused_with_what_to_do(tmp_path: Path) -> None:
    Journal(tmp_path, {"world": "fell"}).add("candidate", candidate=0)
    refused = r"journal\.jsonl: was begun by ecs-eco 0\.2\.0 or an older version.* release 0\.2\.0"
    with pytest.raises(RecordingError, match=refused):
        begin(tmp_path, PLANNED)


def test_confirmation_does_not_depend_on_which_worker_finished_first(tmp_path: Path) -> None:
    def outcome(worlds: list[int]) -> Any:
        journal = Journal(tmp_path / str(worlds), {})
        for world in worlds:
            run = {"training": 1, "world": world, "lived": 5, "extinct": None}
            journal.add("confirmation", candidate=0, cell=(1, world), stages=[{"runs": [run]}])
        return SimpleNamespace(journal=journal)

    one, two = (confirmation(outcome(worlds), 0) for worlds in ([1, 2, 3], [3, 1, 2]))
    assert one == two
    assert [run["world"] for run in one["lives"]] == [1, 2, 3]
