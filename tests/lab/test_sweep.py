"""A whole sweep on an executor: any of them, trainings first, failures told, lost workers replaced."""

from __future__ import annotations

import json
import os
import shutil
import signal
import time
import tomllib
from concurrent.futures import Future, ProcessPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError, ForeignFile
from ecs_eco.lab import compare, folder as lab_folder, run_sweep, sweep as run, work
from ecs_eco.lab.design import design_of
from ecs_eco.lab.folder import Sweep, begin, read_sweep
from ecs_eco.lab.plan import read_plan
from ecs_eco.lab.pool import Pool
from ecs_eco.lab.response import Outcome, interval
from ecs_eco.lab.sweep import do_jobs, unfinished
from ecs_eco.lab.table import missing_for, rows_of
from ecs_eco.record import container
from ecs_eco.record.claim import Claim
from tests.lab.moss import PLAN, WORLD, written


def digests(folder: Path) -> list[str]:
    sweep = read_sweep(folder)
    return [
        json.loads((sweep.job_folder(job.number) / "done.json").read_text())["digest"] for job in sweep.jobs
    ]


def begun(folder: Path, plan: str = PLAN) -> Sweep:
    return begin(folder / "out", design_of(read_plan(written(folder, plan))))


class Here(ProcessPoolExecutor):
    """An executor of nobody's, which does its work at once."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


def test_any_executor_does_a_sweep_and_the_digests_are_the_same(tmp_path: Path) -> None:
    plan = written(tmp_path)
    outcome = run_sweep(plan, tmp_path / "a", workers=1)
    assert sorted(outcome.done) == [0, 1, 2, 3]
    assert outcome.whole
    assert run_sweep(plan, tmp_path / "b", executor=Here()).done == [0, 1, 2, 3]
    assert digests(tmp_path / "a") == digests(tmp_path / "b")
    assert len(set(digests(tmp_path / "a"))) == 4


def test_a_sweep_that_is_done_is_left_and_one_of_another_plan_refused(tmp_path: Path) -> None:
    plan = written(tmp_path)
    run_sweep(plan, tmp_path / "out", workers=1)
    assert run_sweep(plan, tmp_path / "out", workers=1).done == []
    plan.write_text(PLAN.replace("world_seeds = 2", "world_seeds = 3"))
    with pytest.raises(ForeignFile, match="contains the sweep of another plan: world_seeds differs"):
        run_sweep(plan, tmp_path / "out", workers=1)


def test_a_sweep_and_a_comparison_take_a_world_made_in_python(tmp_path: Path) -> None:
    world, hashes = tomllib.loads(WORLD), set()
    for i, made in enumerate((world, load(world), str(written(tmp_path).with_name("moss.toml")))):
        plan = {"world": made, "ticks": 3, "grid": {"species.moss.count": [3, 5]}}
        assert run_sweep(plan, tmp_path / str(i), executor=Here()).done == [0, 1]
        hashes.add(read_sweep(tmp_path / str(i)).hash)
        change, out = ["species.moss.count=7"], tmp_path / f"c{i}"
        assert len(compare(made, change, out=out, seeds=1, ticks=3, executor=Here())["arms"]) == 2
    assert len(hashes) == 1
    with pytest.raises(ConfigError, match='did you mean "moss"'):
        run_sweep({"world": world, "grid": {"species.mos.count": [3]}}, tmp_path / "no", executor=Here())


@pytest.mark.slow
def test_replicates_are_added_until_the_intervals_are_narrow_or_no_seed_is_left(tmp_path: Path) -> None:
    plan = PLAN.replace("world_seeds = 2", "world_seeds = 9").replace("[10, 30]", "[0, 30]")
    sweep = begun(tmp_path, plan)
    rounds = []
    while numbers := missing_for(sweep, "moss.mean", 1.5):
        rounds.append(numbers)
        do_jobs(sweep, Here(), numbers)
    assert [sweep.jobs[n].world_seed for n in rounds[0]] == [1, 1, 2, 2, 3, 3]
    rows = rows_of(sweep)
    counts = [sum(row["point"] == point for row in rows) for point in (0, 1)]
    assert counts[0] < counts[1] <= 9  # the empty point needs fewer
    interval_of = interval([row for row in rows if row["point"] == 0], Outcome("moss.mean", ""))
    assert interval_of.high - interval_of.low <= 1.5
    with pytest.raises(ConfigError, match=r'(?s)--response.*did you mean "moss\.mean"'):
        missing_for(sweep, "mos.mean", 1.0)


def test_births_deaths_and_catches_are_responses(tmp_path: Path) -> None:
    harvest = '[[land_use]]\nkind = "harvest"\nspecies = "moss"\nrate = 0.1\n'
    mowing = '[[interventions]]\nat = 2\nkind = "cull"\nspecies = "moss"\nshare = 0.5\ncause = "mown"\n'
    plan = written(tmp_path, PLAN.replace("world_seeds = 2", "world_seeds = 3"), WORLD + harvest + mowing)
    sweep = begin(tmp_path / "out", design_of(read_plan(plan)))
    for column in ("moss.births", "moss.died.culled", "moss.died.mown", "moss.died.harvested"):
        assert len(missing_for(sweep, column, 1e9)) == 6
    with pytest.raises(ConfigError, match=r'(?s)--response.*did you mean "moss\.died\.harvested"'):
        missing_for(sweep, "moss.died.harvestd", 1e9)
    do_jobs(sweep, Here())
    assert "moss.died.culled" not in rows_of(sweep)[0]  # no run has such a death
    assert missing_for(sweep, "moss.died.culled", 1e-9) == []
    assert missing_for(sweep, "moss.died.mown", 1e9) == []


def test_a_sweep_goes_on_where_its_world_and_plan_are_gone(tmp_path: Path) -> None:
    sweep = begun(tmp_path)
    for file in tmp_path.glob("*.toml"):
        file.unlink()
    shutil.move(sweep.folder, tmp_path / "moved")
    moved = read_sweep(tmp_path / "moved")
    assert do_jobs(moved, Here()).whole
    assert unfinished(moved) == []


def _with_land(folder: Path) -> Path:
    """Write a world with a raster to worlds/; return the raster's file."""
    (folder / "worlds" / "land").mkdir(parents=True)
    grid = "ncols 4\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 5\n" + "1 2 3 4\n" * 4
    (folder / "worlds" / "land" / "hill.asc").write_text(grid, encoding="utf-8")
    land = 'edges = "walls"\n[terrain]\nraster = "land/hill.asc"\ncell = 5.0\n'
    text = WORLD.replace('edges = "torus"\n', land).replace("[12.0, 12.0]", "[20.0, 20.0]")
    assert land in text
    (folder / "worlds" / "world.toml").write_text(text, encoding="utf-8")
    return folder / "worlds" / "land" / "hill.asc"


def test_a_sweep_keeps_the_land_that_its_world_names(tmp_path: Path) -> None:
    _with_land(tmp_path)
    plan = {"world": str(tmp_path / "worlds" / "world.toml"), "ticks": 2}
    sweep = begin(tmp_path / "out", design_of(read_plan(plan)))
    shutil.rmtree(tmp_path / "worlds")
    shutil.move(sweep.folder, tmp_path / "moved")
    assert do_jobs(read_sweep(tmp_path / "moved"), Here()).whole


@pytest.mark.parametrize("killed_in", ["begin", "_keep_files", "write"])
def test_a_sweep_that_was_killed_while_it_began_begins_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, killed_in: str
) -> None:
    hill = _with_land(tmp_path)
    (tmp_path / "plan.toml").write_text('world = "worlds/world.toml"\nticks = 2\n', encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    with monkeypatch.context() as killed:
        killed.setattr(container if killed_in == "begin" else lab_folder, killed_in, lambda *_: 1 / 0)
        killed.setattr(Claim, "release", lambda _: None)  # a killed process leaves its lock file
        failed = CliRunner().invoke(app, ["sweep", "plan.toml", "--out", "out", "--workers", "1"])
        assert isinstance(failed.exception, ZeroDivisionError), failed.output
    (tmp_path / "out" / ".lock").unlink()
    (tmp_path / "out" / ".lock").touch()
    done = CliRunner().invoke(app, ["sweep", "plan.toml", "--out", "out", "--workers", "1", "-q"])
    assert done.exit_code == 0, done.output
    copy, before = tmp_path / "out" / "world" / "land" / "hill.asc", hill.read_bytes()
    assert copy.read_bytes() == before
    hill.write_bytes(before.replace(b"3 4\n", b"3 5\n"))
    with pytest.raises(ForeignFile, match=r"contains the sweep of another plan: world_hash"):
        begin(tmp_path / "out", design_of(read_plan("plan.toml")))
    assert copy.read_bytes() == before


def fails_at_2(folder: str, number: int, allowed: Any) -> None:
    if number == 2:
        raise ValueError("no moss")


def test_a_job_that_fails_stops_no_other_and_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = begun(tmp_path)
    monkeypatch.setattr(run, "run_job", fails_at_2)
    outcome = do_jobs(sweep, Here())
    assert outcome.done == [0, 1, 3]
    assert outcome.failed == {2: "ValueError: no moss"}


def killed_twice(folder: str, number: int, allowed: Any) -> None:
    """The worker of job 1 is killed in its first two calls."""
    if number != 1:
        return  # another may read the note just when it is written
    note = Path(folder) / "kills"
    kills = int(note.read_text()) if note.exists() else 0
    if kills < 2:
        note.write_text(str(kills + 1))
        os.kill(os.getpid(), signal.SIGKILL)


def always_killed(folder: str, number: int, allowed: Any) -> None:
    if number == 1:
        time.sleep(0.3)  # the others are done by then
        os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.slow
def test_a_job_whose_worker_is_killed_is_called_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep = begun(tmp_path)
    monkeypatch.setattr(run, "run_job", killed_twice)
    with Pool(2) as pool:
        outcome = do_jobs(sweep, pool)
    assert sorted(outcome.done) == [0, 1, 2, 3]
    assert outcome.retried >= 2


@pytest.mark.slow
def test_a_job_whose_worker_is_always_killed_fails_in_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep = begun(tmp_path)
    monkeypatch.setattr(run, "run_job", always_killed)
    monkeypatch.setattr(work, "RETRIES", 1)
    with Pool(2) as pool:
        outcome = do_jobs(sweep, pool, [1])
    assert "was killed 2 times (out of memory?)" in outcome.failed[1]


def test_what_a_job_needs_is_trained_before_it_and_a_training_that_fails_fails_its_jobs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small = {"species.grass.count": 60, "species.deer.count": 12, "species.wolf.count": 2}
    plan = {"world": "predator-prey", "set": small, "training_seeds": 2, "treatments": ["random-policy"]}
    sweep = begin(tmp_path / "out", design_of(read_plan(plan)))
    calls: list[Any] = []

    def train(folder: str, name: str, allowed: Any) -> None:
        calls.append(name)
        if name.endswith("seed-2"):
            raise ValueError("learns nothing")

    monkeypatch.setattr(run, "train", train)
    monkeypatch.setattr(run, "run_job", lambda folder, number, allowed: calls.append(number))
    outcome = do_jobs(sweep, Here())
    first, second = sweep.trainings
    assert calls.index(first) < calls.index(0)
    assert set(calls) == {first, second, 0, 2}  # 1 has the training that failed
    assert outcome.failed == {1: "its training failed: ValueError: learns nothing"}
