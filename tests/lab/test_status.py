"""How far a sweep is, from its folder alone."""

from __future__ import annotations

import json
import time
from pathlib import Path

import pytest

from ecs_eco.lab.jobs import _noting, run_job
from ecs_eco.lab.status import Survey
from ecs_eco.record.claim import Claim
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
    assert status.remaining is not None
    assert abs(status.remaining - 15 / 0.2) < 5
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


def test_a_job_of_a_process_that_is_gone_does_not_run(tmp_path: Path) -> None:
    sweep = begun(tmp_path)
    sweep.job_folder(0).mkdir(parents=True)
    (sweep.job_folder(0) / ".lock").write_text(json.dumps({"pid": 2**22 + 5, "started": 1, "host": "gone"}))
    (sweep.job_folder(0) / "progress.json").write_text(json.dumps({"at": time.time() - 3600, "done": 2}))
    assert Survey(sweep).look().waiting == [0, 1, 2, 3]
