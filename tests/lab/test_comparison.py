"""A comparison: what is trained, what is run, and what is done when some of it fails."""

from __future__ import annotations

import os
import signal
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path

import pytest

from ecs_eco.engine.errors import ForeignFile
from ecs_eco.lab import work
from ecs_eco.lab.comparison import Comparison, Key, compare
from ecs_eco.lab.pool import Pool
from ecs_eco.lab.treatments import arms_of
from ecs_eco.lab.work import run_jobs
from ecs_eco.record.seal import read_manifest

OUT = Path("out")


@pytest.fixture(scope="module")
def arms():
    return arms_of("predator-prey", [], ["random-policy", "random-policy:deer", "species.deer.count=50"])


def comparison(arms, training_seeds=None, retrain=False) -> Comparison:
    return Comparison(OUT, arms, 10, range(1, 3), training_seeds, retrain)


def test_where_nothing_is_trained_each_arm_runs_once_with_each_seed(arms) -> None:
    plain = comparison(arms[:2])
    assert plain.trainings == {}
    assert {str(key): folder for key, (*_, folder) in plain.runs.items()} == {
        "world, seed 1": OUT / "world" / "seed-1",
        "world, seed 2": OUT / "world" / "seed-2",
        "random-policy, seed 1": OUT / "random-policy" / "seed-1",
        "random-policy, seed 2": OUT / "random-policy" / "seed-2",
    }


def test_each_trained_policy_meets_each_world_seed(arms) -> None:
    crossed = comparison(arms, training_seeds=[1, 2])
    assert [(folder, seed) for folder, _, seed in crossed.trainings.values()] == [
        (OUT / "policies" / "world" / f"seed-{k}", k) for k in (1, 2)
    ]
    trained = [key for key in crossed.runs if key.training_seed is not None]
    assert [(key.arm, key.training_seed) for key in trained] == [
        (arm, k) for arm in ("world", "random-policy-deer", "species.deer.count-50") for k in (1, 1, 2, 2)
    ]
    arm, *_, folder = crossed.runs[Key("random-policy-deer", 2, 1)]
    assert folder == OUT / "random-policy-deer" / "training-1" / "seed-2"
    assert arm.policies == {"deer": "random", "wolf": str(OUT / "policies" / "world" / "seed-1")}
    assert str(Key("world", 2, 1)) == "world, seed 2, training seed 1"


def test_arms_with_other_values_are_trained_anew_where_that_is_asked_for(arms) -> None:
    folders = [comparison(arms, [1], retrain).policies_folder(arms[3]).name for retrain in (False, True)]
    assert folders == ["world", "species.deer.count-50"]
    places = {place.parent.name for place in comparison(arms, [1], True).trainings}
    assert places == {"world", "species.deer.count-50"}


def test_policies_are_said_in_words(arms) -> None:
    words = list(comparison(arms, [1, 2]).policies_in_words().values())
    assert words[:3] == [
        "policies trained in the unchanged world, from 2 training seeds",
        "untrained policies and has no training seed",
        "policies of wolf trained in the unchanged world, the same as the first arm, from 2 training seeds",
    ]


def test_a_job_that_fails_is_reported_and_the_others_are_done() -> None:
    failures, progress = [], []
    jobs = {Key("a", 1): (int, "1"), Key("a", 2): (int, "x"), Key("a", 3): (int, "3")}
    results = run_jobs(
        jobs, Pool(1), lambda *n: progress.append(n), lambda key, error: failures.append((key, type(error)))
    )
    assert results == {Key("a", 1): 1, Key("a", 3): 3}
    assert failures == [(Key("a", 2), ValueError)]
    assert progress == [(0, 3), (1, 3), (1, 3), (2, 3)]


def test_a_job_begins_when_what_it_waits_for_is_done_and_fails_if_that_fails() -> None:
    order: list[object] = []
    calls = {
        "good": (order.append, "good"),
        "bad": (int, "x"),
        1: (order.append, 1),
        2: (order.append, 2),
        3: (order.append, 3),
        4: (order.append, 4),
    }
    failures: list[tuple[object, type]] = []
    results = run_jobs(
        calls,
        Pool(1),
        lambda *_: None,
        lambda key, error: failures.append((key, type(error))),
        after={1: "good", 3: "bad", 4: 3},
    )
    assert order == ["good", 2, 1]
    assert list(results) == ["good", 2, 1]
    assert failures == [(key, ValueError) for key in ("bad", 3, 4)]


def test_a_killed_worker_is_reported_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(work, "RETRIES", 1)
    failures = []
    jobs = {Key("a", seed): (os._exit, 1) for seed in range(6)}
    with Pool(2) as pool:
        results = run_jobs(jobs, pool, lambda *_: None, lambda _, error: failures.append(type(error)))
    assert results == {}
    assert failures == [BrokenProcessPool]


def killed_once(note: str) -> str:
    """The worker is killed in the first call."""
    if not os.path.exists(note):
        Path(note).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "again"


@pytest.mark.slow
def test_a_run_whose_worker_is_killed_is_made_again(tmp_path: Path) -> None:
    failures = []
    jobs = {Key("a", seed): (killed_once, str(tmp_path / str(seed))) for seed in range(2)}
    with Pool(2) as pool:
        results = run_jobs(jobs, pool, lambda *_: None, lambda *why: failures.append(why))
    assert set(results.values()) == {"again"}
    assert failures == []


# a whole comparison from Python, on an executor of one's own

WORLD = """\
format = 1
name = "fell"
ticks = 20
[space]
size = [20.0, 20.0]
[species.mite]
count = 4
body = { radius = 0.1 }
metabolism = { energy = 0.5, energy_max = 1.0, basal = 0.02 }
lethal = [{ property = "energy", min = 0.0, low = "starved" }]
"""
COLD = "species.mite.metabolism.basal=0.05"


@pytest.fixture
def world(tmp_path: Path) -> str:
    path = tmp_path / "fell.toml"
    path.write_text(WORLD, encoding="utf-8")
    return str(path)


def digests(folder: Path) -> dict[str, str]:
    return {
        str(path.parent.relative_to(folder)): read_manifest(path.parent)["digest"]
        for path in folder.glob("*/*/manifest.json")
    }


@pytest.mark.slow
def test_an_executor_of_ones_own_gives_the_same_and_is_left_running(world: str, tmp_path: Path) -> None:
    compare(world, [COLD], out=tmp_path / "here", seeds=2, workers=1)
    with ProcessPoolExecutor(1, get_context("spawn")) as own:
        result = compare(world, [COLD], out=tmp_path / "there", seeds=2, executor=own)
        assert own.submit(int, "3").result() == 3
    assert list(result["arms"]) == ["world", "species.mite.metabolism.basal-0.05"]
    assert len(digests(tmp_path / "here")) == 4
    assert digests(tmp_path / "here") == digests(tmp_path / "there")


@pytest.mark.slow
def test_it_goes_on_where_it_was_and_another_one_is_refused(world: str, tmp_path: Path) -> None:
    progress: list[tuple[int, int]] = []
    compare(world, [COLD], out=tmp_path / "out", seeds=1, workers=1)
    compare(world, [COLD], out=tmp_path / "out", seeds=2, workers=1, progress=lambda *n: progress.append(n))
    assert progress[-1] == (2, 2)
    with pytest.raises(ForeignFile, match=r"another comparison: ticks differs \(ticks: 20 then, 30 now\)"):
        compare(world, [COLD], out=tmp_path / "out", seeds=2, ticks=30)
