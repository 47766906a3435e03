"""sweep: a plan's jobs, their state, what is left of them, their table; and what is refused."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.cli.sweep import duration
from ecs_eco.lab import sweep as running
from ecs_eco.lab.jobs import UNFINISHED
from tests.lab.moss import PLAN, written


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    written(tmp_path)
    return tmp_path


def invoke(*arguments: str, code: int = 0) -> str:
    done = CliRunner().invoke(app, ["sweep", *arguments], terminal_width=120)
    assert done.exit_code == code, done.output + repr(done.exception)
    return done.output


def test_a_plan_is_run_looked_at_and_collected(here: Path) -> None:
    out = invoke("plan.toml", "--workers", "1", "--out", "out")
    assert "4 jobs are done in" in out
    assert "4 of 4 jobs are already done" in invoke("plan.toml", "--workers", "1", "--out", "out")
    assert "24 of 24" in invoke("status", "out").replace("\n", " ")
    assert "all species persist in 4 of 4 runs of 6 ticks, at 2 points" in invoke("collect", "out")
    assert (here / "out" / "runs.parquet").is_file()
    assert (here / "out" / "sweep.html").is_file()
    (here / "plan.toml").write_text(PLAN.replace("ticks = 6", "ticks = 7"))
    assert "another plan: ticks differs" in invoke("plan.toml", "--out", "out", code=2)


def test_failed_jobs_are_told_with_how_to_try_them_again(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patched:
        patched.setattr(running, "run_job", lambda folder, number, allowed: 1 / 0)
        out = invoke("plan.toml", "--workers", "1", "--out", "out", code=1)
    assert "job 0 (count 10; seed 1) and 3 more: ZeroDivisionError" in out
    assert "To retry the failed jobs: ecs-eco sweep resume" in out
    assert "4 jobs are done" in invoke("resume", "out", "--workers", "1")


def test_jobs_are_done_by_number(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "run_job", lambda *_: None)
    invoke("plan.toml", "--workers", "1", "--out", "out")
    out = invoke("job", "out", "1", "3")
    assert "job 1 (count 10; seed 2): done" in out
    assert "job 3" in out
    assert "no such job; expected: a number from 0 to 3" in invoke("job", "out", "4", code=2)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["plan.toml", "--on", "rya"], ["--on", "no such engine"]),
        (["plan.toml", "--sbatch=--time=1"], ["--sbatch", "applies only to SLURM", "--on slurm"]),
        (["no.toml"], ["PLAN", "no.toml"]),
        (["plan.toml", "--until-width", "1", "--response", "mos.mean"], ["--response", '"moss.mean"']),
        (["status", "."], ["is not a folder of a sweep"]),
        (["plan.toml", "--out", "."], ["is not empty"]),
    ],
)
def test_wrong_arguments_are_refused(arguments: list[str], words: list[str]) -> None:
    out = invoke(*arguments, code=2)
    for word in words:
        assert word in out, out
    assert not Path("runs").exists()


def test_times_are_for_people() -> None:
    assert [duration(t) for t in (None, 3.2, 89, 600, 12000)] == ["–", "3 s", "89 s", "10 min", "3 h 20 min"]


@pytest.mark.slow
def test_sigterm_leaves_a_checkpoint_and_says_unfinished(here: Path) -> None:
    (here / "plan.toml").write_text(PLAN.replace("ticks = 6", "ticks = 1_000_000"))
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(running, "run_job", lambda *_: None)
        invoke("plan.toml", "--workers", "1", "--out", "out")
    job = subprocess.Popen(
        [sys.executable, "-c", "from ecs_eco.cli import main; main()", "sweep", "job", "out", "0"],
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    note = here / "out" / "jobs" / "0000" / "progress.json"
    until = time.monotonic() + 120
    while time.monotonic() < until and not (note.exists() and json.loads(note.read_text())["done"]):
        time.sleep(0.1)
    job.send_signal(signal.SIGTERM)
    _, errors = job.communicate(timeout=60)
    assert job.returncode == UNFINISHED, errors
    assert "Unfinished" in errors
    assert list((here / "out" / "jobs" / "0000" / "run" / "checkpoints").glob("tick-*.safetensors"))
    assert "1 of 4" not in invoke("status", "out")
