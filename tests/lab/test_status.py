"""How far a sweep is, from its folder alone."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ecs_eco.lab import jobs, sweep as run
from ecs_eco.lab.folder import read_sweep
from ecs_eco.lab.jobs import _noting, run_job
from ecs_eco.lab.pool import Pool
from ecs_eco.lab.sweep import Outcome, Survey, do_jobs
from ecs_eco.record.claim import Claim
from tests.lab.moss import PLAN
from tests.lab.test_sweep import begun


def test_jobs_are_done_running_waiting_or_failed(tmp_path: Path) -> None:
    sweep = begun(tmp_path)
    survey = Survey(sweep)
    assert survey.look().waiting == [0, 1, 2, 3]
    run_job(sweep.folder, 0)
    for number in (1, 2):
        sweep.job_folder(number).mkdir(parents=True)
    (sweep.job_folder(1) / "failed.json").write_text(json.dumps({"error": "ValueError", "text": "no moss"}))
    note = {"began": time.time() - 10, "at": time.time(), "from": 1, "done": 3}
    (sweep.job_folder(2) / "progress.json").write_text(json.dumps(note))
    with Claim(sweep.job_folder(2)):
        status = survey.look()
    assert (status.done, status.running, status.waiting) == ([0], [2], [3])
    assert status.failed == {1: "ValueError: no moss"}
    assert status.errors() == [("ValueError: no moss", [1])]
    assert (status.ticks, status.ticks_in_all) == (6 + 3, 24)
    assert abs(status.rate - 0.2) < 0.01
    assert status.left == pytest.approx(3 / 0.2, rel=0.05)
    assert status.remaining == pytest.approx(status.left + status.each)  # of job 2, and of job 3
    assert survey.look().waiting == [2, 3]  # nobody has it now


def test_a_job_that_has_just_begun_promises_no_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep, now = begun(tmp_path), time.time()
    for number in (0, 1):
        sweep.job_folder(number).mkdir(parents=True)
    monkeypatch.setattr(time, "time", lambda: now)
    with Claim(sweep.job_folder(0)):
        note = _noting(sweep.job_folder(0) / "progress.json", 1000)
        note(0, 1000)  # then it trains, and compiles
        now += 40
        monkeypatch.setattr("ecs_eco.lab.jobs.PACE", 0.0)
        note(2, 1000)
        now += 2
        note(102, 1000)
        assert (Survey(sweep).look().running, Survey(sweep).look().remaining) == ([0], None)
        now += 4
        note(302, 1000)
        assert Survey(sweep).look().rate == pytest.approx(50)
        with Claim(sweep.job_folder(1)):  # which has not noted anything
            (sweep.job_folder(1) / "progress.json").write_text(json.dumps({"at": now, "done": 0}))
            assert Survey(sweep).look().rate == pytest.approx(100)


def test_jobs_that_compile_do_not_count_for_those_that_follow(tmp_path: Path) -> None:
    survey = Survey(begun(tmp_path, PLAN.replace("world_seeds = 2", "world_seeds = 12")))
    ends = ((0, 31), (0, 31), (31, 32), (31, 32), (32, 33))
    survey._done = {i: {"began": a, "ended": b, "seconds": 0.9} for i, (a, b) in enumerate(ends)}
    status = survey.look()
    assert (len(status.waiting), status.each) == (19, pytest.approx(1.0))
    assert status.remaining == pytest.approx(19 / 2, rel=0.05)  # two at a time


SECONDS = {10: 0.5, 30: 2.0}  # length of a run by the number of founders


def lasts(folder: str, number: int, allowed: Any) -> Any:
    """Run a job whose ticks take a known time."""
    seconds = SECONDS[read_sweep(folder).jobs[number].values["species.moss.count"]]

    def slowly(path: Path, ticks: int) -> Callable[[int, int], None]:
        note = _noting(path, ticks)
        return lambda done, of: (time.sleep(seconds / ticks), note(done, of))[1]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(jobs, "_noting", slowly)
        return run_job(folder, number)


@pytest.mark.slow
def test_the_time_left_is_right_within_a_factor_of_two_after_five_jobs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep = begun(tmp_path, PLAN.replace("world_seeds = 2", "world_seeds = 12"))
    survey, told = Survey(sweep), dict[int, tuple[float, float]]()

    def look(outcome: Outcome) -> None:
        told[len(outcome.done)] = (time.time(), survey.look().remaining or 0.0)

    monkeypatch.setattr(run, "run_job", lasts)
    with Pool(2) as pool:
        assert do_jobs(sweep, pool, progress=look).whole
    end, _ = told[24]
    shares = [left / (end - at) for n, (at, left) in told.items() if 5 <= n <= 15]
    assert 0.5 <= np.median(shares) <= 2, (
        shares
    )  # the median, as other work on this machine changes its speed


def test_a_job_of_a_process_that_is_gone_does_not_run(tmp_path: Path) -> None:
    sweep = begun(tmp_path)
    sweep.job_folder(0).mkdir(parents=True)
    (sweep.job_folder(0) / ".lock").write_text(json.dumps({"pid": 2**22 + 5, "started": 1, "host": "gone"}))
    (sweep.job_folder(0) / "progress.json").write_text(json.dumps({"at": time.time() - 3600, "done": 2}))
    assert Survey(sweep).look().waiting == [0, 1, 2, 3]
