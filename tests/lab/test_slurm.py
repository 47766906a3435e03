"""Sweeps on SLURM: scripts and arrays, and a stand-in that signals, preempts and queues again."""

from __future__ import annotations

import json
import os
import shlex
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Collection, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.engine.errors import ConfigError, RecordingError
from ecs_eco.explain import Edit, take_out, taken_out
from ecs_eco.lab import slurm as slurm_module
from ecs_eco.lab.design import design_of
from ecs_eco.lab.folder import Sweep, begin, read_sweep
from ecs_eco.lab.jobs import read_done, run_job
from ecs_eco.lab.plan import read_plan
from ecs_eco.lab.slurm import Options, jobs_of, queued_jobs, resume, script, submit_jobs
from ecs_eco.record import seal
from ecs_eco.record.claim import owner_of
from tests.explain.newts import recorded
from tests.lab.moss import PLAN, written

LONG = 'world = "moss.toml"\nticks = 30000\nworld_seeds = 2\ncheckpoint_every = 1000\n'
AGAIN = ("preempt", "requeue")  # what the stand-in notes of a task that it queues again
STAND_IN = Path(__file__).with_name("slurm_stand_in.py")


@pytest.fixture
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The stand-in's commands on the path; its state."""
    place = tmp_path / "bin"
    place.mkdir()
    for name in ("sbatch", "squeue", "scontrol", "preempt", "notice"):
        command = place / name
        command.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{STAND_IN}" {name} "$@"\n')
        command.chmod(command.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{place}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("ECS_ECO_PORTABLE", "0")  # the mode of this process, whose libraries are loaded
    monkeypatch.setenv("SLURM_STAND_IN", str(tmp_path / "slurm"))
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))
    return tmp_path / "slurm"


def sweep_in(folder: Path, plan: str = PLAN) -> Sweep:
    return begin(folder / "sweep", design_of(read_plan(str(written(folder, plan)))))


def submit(sweep: Sweep, numbers: Sequence[int], options: Options | None = None) -> list[str]:
    return submit_jobs(jobs_of(sweep), sweep.evenly(numbers), options or Options())


def queued(sweep: Sweep) -> set[int]:
    return queued_jobs(jobs_of(sweep), len(sweep.jobs))


def tasks(slurm: Path, array: str) -> dict[str, Any]:
    return dict(json.loads((slurm / "state.json").read_text())["arrays"][array]["tasks"])


def until(condition: Any, seconds: float = 240) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "not in time"
        time.sleep(0.05)


def test_a_script_asks_for_notice_and_to_be_queued_again(tmp_path: Path) -> None:
    sweep = sweep_in(tmp_path)
    text = script(jobs_of(sweep), [7, 3], Options(limit=7, more=("--time=2:00:00", "--qos=long")), after="55")
    head = [line for line in text.splitlines() if line.startswith("#SBATCH")]
    assert {
        "#SBATCH --requeue",
        "#SBATCH --array=0-1%7",
        "#SBATCH --signal=B:TERM@120",
        "#SBATCH --open-mode=append",
        "#SBATCH --dependency=afterany:55",
        "#SBATCH --time=2:00:00",
        f"#SBATCH --output={sweep.folder}/slurm/%A_%a.log",
    } <= set(head)
    assert head[-1] == "#SBATCH --qos=long"  # what the user says comes last
    assert "jobs=(7 3)" in text
    assert '"${jobs[SLURM_ARRAY_TASK_ID]}"' in text
    assert f"{sys.executable} -P -c" in text  # whatever modules lie where the job runs


def test_nothing_of_a_folder_becomes_a_command_of_its_script(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "executable", "/bin/true")
    sweep = sweep_in(tmp_path / "it's $(touch mark) 5% #x")
    lines = script(jobs_of(sweep), [0], Options()).splitlines()
    [output] = [shlex.split(line)[1] for line in lines if "--output" in line]
    assert output == f"--output={sweep.folder}/slurm/%A_%a.log".replace("5% ", "5%% ")
    subprocess.run(
        ["bash", "-c", "\n".join(lines)],
        cwd=tmp_path,
        check=True,
        env=os.environ | {"SLURM_ARRAY_TASK_ID": "0"},
    )
    assert not list(tmp_path.rglob("mark"))
    with pytest.raises(ConfigError, match="cannot be a line of a batch script"):
        script(jobs_of(sweep_in(tmp_path / "a\ntouch mark")), [0], Options())
    with pytest.raises(ConfigError, match="--sbatch"):
        script(jobs_of(sweep), [0], Options(more=("--time=1\ntouch mark",)))


def test_a_hash_that_is_none_is_refused(tmp_path: Path) -> None:
    sweep = sweep_in(tmp_path)
    manifest = {k: v for k, v in seal.read_manifest(sweep.folder, "sweep.json").items() if k != "seal"}
    seal.write_manifest(sweep.folder, manifest | {"hash": "a\n. ./a\n#"}, "sweep.json")
    with pytest.raises(RecordingError, match=r"sweep\.json: hash: "):
        read_sweep(sweep.folder)


def test_a_note_of_arrays_with_other_values_is_refused(tmp_path: Path) -> None:
    sweep = sweep_in(tmp_path)
    (sweep.folder / "slurm").mkdir()
    seal.write_manifest(sweep.folder / "slurm", {"arrays": [{"id": "1\nx", "jobs": [0]}]}, "submitted.json")
    with pytest.raises(RecordingError, match=r"submitted\.json: arrays\.0\.id: "):
        queued(sweep)


def test_arrays_of_an_earlier_version_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = sweep_in(tmp_path)
    (sweep.folder / "slurm").mkdir()
    arrays = [{"id": "7", "offset": 1, "indices": "0,2"}, {"id": "8", "jobs": [3, 0]}]
    seal.write_manifest(sweep.folder / "slurm", {"arrays": arrays}, "submitted.json")
    monkeypatch.setattr(slurm_module, "_slurm", lambda *_: "7 0\n7 1\n8 0\n9 1\n")
    assert queued(sweep) == {1, 2, 3}


@pytest.mark.slow
def test_jobs_that_are_told_to_end_and_preempted_leave_the_same_as_alone(tmp_path: Path, slurm: Path) -> None:
    sweep = sweep_in(tmp_path, LONG)
    [array] = submit(sweep, [0, 1], Options(limit=2))
    assert queued(sweep) == {0, 1}
    assert resume(sweep, [0, 1]) == ([], [0, 1])
    for commands in ({0: "preempt", 1: "notice"}, {0: "notice", 1: "preempt"}):
        held = hold_under_way(sweep, commands)
        often = {number: times(slurm, array, number, *AGAIN) for number in commands}
        for number, command in commands.items():
            os.spawnlp(os.P_WAIT, command, command, array, str(number))
        told = next(number for number, command in commands.items() if command == "notice")
        until(lambda told=told: times(slurm, array, told, "signalled") == 1)
        for pid in held.values():
            with suppress(ProcessLookupError):  # the preempted is gone
                os.kill(pid, signal.SIGCONT)
        for number in commands:
            until(lambda number=number, n=often[number]: times(slurm, array, number, *AGAIN) > n)
    until(lambda: not queued(sweep))
    alone = sweep_in(tmp_path / "alone", LONG)
    for number in (0, 1):
        words = log(slurm, array, number)
        assert words.count("preempt") == words.count("signalled") == words.count("requeue") == 1, words
        assert words[-1] == "COMPLETED"
        assert (read_done(sweep, number) or {})["digest"] == run_job(alone.folder, number)["digest"]


def hold_under_way(sweep: Sweep, numbers: Collection[int]) -> dict[int, int]:
    """Stop the process of each job, once it has left a checkpoint later than those that are there."""
    there, held = {number: checkpoints(sweep, number) for number in numbers}, dict[int, int]()

    def hold() -> bool:
        for number in numbers:
            if number not in held and checkpoints(sweep, number) - there[number]:
                held[number] = int((owner_of(sweep.job_folder(number)) or {})["pid"])
                os.kill(held[number], signal.SIGSTOP)
        return len(held) == len(numbers)

    until(hold)
    return held


def checkpoints(sweep: Sweep, number: int) -> set[Path]:
    return set((sweep.job_folder(number) / "run" / "checkpoints").glob("tick-*.safetensors"))


def times(slurm: Path, array: str, number: int, *words: str) -> int:
    return sum(word in words for word in log(slurm, array, number))


def log(slurm: Path, array: str, number: int) -> list[str]:
    return list(tasks(slurm, array)[str(number)]["log"])


def test_a_task_is_told_ahead_of_its_time_limit_and_queued_again_where_it_is_unfinished(
    tmp_path: Path, slurm: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    work = tmp_path / "work"
    work.write_text(
        "#!/bin/bash\ntrap 'exit 75' TERM\n[[ $SLURM_RESTART_COUNT == 1 ]] || { sleep 60 & wait; }\n"
    )
    work.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(work))
    sweep = sweep_in(tmp_path)
    [array] = submit(sweep, [2], Options(notice=58, more=("--time=1:00",)))
    until(lambda: not queued(sweep))
    assert log(slurm, array, 0) == ["started", "signalled", "requeue", "started", "COMPLETED"]


def test_any_beginning_of_the_tasks_is_even_over_points_arms_and_seeds(
    tmp_path: Path, slurm: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "executable", "/bin/true")
    monkeypatch.setenv("MAX_ARRAY_SIZE", "10")
    treated = PLAN.replace("world_seeds = 2", 'world_seeds = 4\ntreatments = ["species.moss.count=7"]')
    sweep = sweep_in(tmp_path, treated)
    submit(sweep, list(reversed(range(16))))
    arrays = seal.read_manifest(sweep.folder / "slurm", "submitted.json")["arrays"]
    order = [sweep.jobs[number] for array in arrays for number in array["jobs"]]
    assert [len(array["jobs"]) for array in arrays] == [10, 6]
    for of, most in (("point", 1), ("treatment", 1), ("world_seed", 2)):
        kinds = [getattr(job, of) for job in order]
        for n in range(1, 16):
            counts = [kinds[:n].count(kind) for kind in set(kinds)]
            assert max(counts) - min(counts) <= most, (of, n)


@pytest.mark.slow
def test_what_is_unfinished_is_submitted_once_more_in_arrays_of_the_size_allowed(
    tmp_path: Path, slurm: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MAX_ARRAY_SIZE", "2")
    sweep = sweep_in(tmp_path)
    digests = [run_job(sweep.folder, 1)["digest"]]
    ids, waiting = resume(sweep, [0, 2, 3])
    assert (len(ids), waiting) == (2, [])
    assert [list(tasks(slurm, array)) for array in ids] == [["0", "1"], ["0"]]
    until(lambda: not queued(sweep))
    digests += [(read_done(sweep, n) or {})["digest"] for n in (0, 2, 3)]
    assert len(digests) == 4
    assert all(digests)


def test_where_slurm_is_not_or_refuses_it_is_said(
    tmp_path: Path, slurm: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep = sweep_in(tmp_path)
    with pytest.raises(ConfigError, match="sbatch refused: sbatch: error: invalid partition specified"):
        submit(sweep, [0], Options(more=("--partition=nowhere",)))
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(
        ConfigError, match="SLURM is not available: there is no scontrol; expected: a machine that"
    ):
        submit(sweep, [0])


def test_the_command_submits_what_is_not_done_and_says_so(
    tmp_path: Path, slurm: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "executable", "/bin/true")
    plan = str(written(tmp_path))
    begun, again = (
        CliRunner().invoke(app, ["sweep", *words, "--on", "slurm", "--sbatch=--time=0:30"])
        for words in ([plan, "--out", str(tmp_path / "out")], ["resume", str(tmp_path / "out")])
    )
    assert "submitted 4 jobs to SLURM: 100; to show progress: ecs-eco sweep status" in begun.output
    assert "submitted" in again.output or "4 jobs are already queued or running" in again.output
    text = (tmp_path / "out" / "slurm" / "array-1.sh").read_text()
    assert "#SBATCH --time=0:30\n" in text
    assert "%100\n" in text


@pytest.mark.slow
def test_forks_on_slurm_are_those_of_this_machine(
    tmp_path: Path, slurm: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(taken_out, "POLL", 0.2)
    run, done = recorded(tmp_path / "run", ticks=1), list[tuple[int, int]]()
    hungry = Edit("newt", "letter", "hunger", 0, "B")
    how: dict[str, Any] = {"tick": 0, "forks": 2, "ticks": 5, "engine": "slurm", "workers": 1}
    there = take_out(run, hungry, "A", progress=lambda *one: done.append(one), **how)
    assert done == [(1, 2), (2, 2)]
    (script,) = run.glob("explain/*/slurm/array-1.sh")
    assert "#SBATCH --array=0-1%1" in script.read_text()
    (place,) = [path.parent for path in run.glob("explain/*/what.json")]
    for path in place.glob("fork-*"):
        path.unlink()
    assert take_out(run, hungry, "A", **how | {"engine": "local"}).to_pandas().equals(there.to_pandas())
    (place / "fork-0001.json").unlink()
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(RecordingError, match="1 forks ended without a result: see the logs in"):
        take_out(run, hungry, "A", **how)
