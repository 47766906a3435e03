"""SLURM: arrays of numbered jobs, such as those of a sweep, which write checkpoints and are requeued."""

import os
import re
import shlex
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import Field

from ecs_eco.engine.errors import refusal
from ecs_eco.engine.files import write
from ecs_eco.engine.processes import python
from ecs_eco.inputs.section import Section
from ecs_eco.lab.folder import Sweep
from ecs_eco.lab.jobs import UNFINISHED
from ecs_eco.lab.pool import PINS
from ecs_eco.record.container import inside
from ecs_eco.record.manifest import Tick
from ecs_eco.record.seal import read_sealed, write_manifest

FOLDER = "slurm"  # folder in a sweep for scripts, logs and the list of submitted arrays
SUBMITTED = "submitted.json"
ARRAY_SIZE = 1001  # SLURM's default MaxArraySize; indices are below it
SCRIPT = """\
#!/bin/bash
{options}
{pins}
trap 'told=1; kill -TERM "$work" 2>/dev/null' TERM
jobs=({jobs})
{command} "${{jobs[SLURM_ARRAY_TASK_ID]}}" &
work=$!
wait "$work"; code=$?
if [[ $told ]]; then wait "$work"; code=$?; fi  # the signal ended the first wait
if [[ $code == {unfinished} || ( $told && $code == 143 ) ]]; then
    scontrol requeue "$SLURM_JOB_ID" 2>/dev/null  # whoever is preempted is queued again already
fi
exit "$code"
"""


@dataclass(frozen=True)
class Options:
    """The options of a submission."""

    limit: int = 100  # jobs at a time
    notice: int = 120  # [s] between the signal to write a checkpoint and the job's time limit
    more: tuple[str, ...] = ()  # further options for sbatch: "--time=2:00:00", "--mem=4G"


class Jobs(NamedTuple):
    """Numbered jobs of one command."""

    name: str  # of their arrays in the queue
    place: Path  # folder for scripts and logs
    command: Sequence[str]  # receives a job's number as its last argument


def submit_jobs(jobs: Jobs, numbers: Sequence[int], options: Options = Options()) -> list[str]:
    """Submit jobs with these numbers, in this order, as consecutive arrays; return the arrays' ids. Each job is
    one task with one CPU. Before its time limit, it writes a checkpoint and is requeued, as it is if SLURM
    preempts it or its node fails. Raises ConfigError if SLURM is missing or rejects the jobs."""
    jobs.place.mkdir(exist_ok=True)
    arrays, before = _arrays(jobs.place), ""
    told = re.search(r"^MaxArraySize\s*=\s*(\d+)", _slurm("scontrol", "show", "config"), re.MULTILINE)
    ids, size = [], int(told[1]) if told else ARRAY_SIZE
    for some in (numbers[at : at + size] for at in range(0, len(numbers), size)):
        path = write(jobs.place / f"array-{len(arrays) + 1}.sh", script(jobs, some, options, before))
        path.chmod(0o755)
        before = _slurm("sbatch", "--parsable", str(path)).strip().partition(";")[0]
        ids.append(before)
        arrays.append({"id": before, "jobs": list(some)})
        write_manifest(jobs.place, {"arrays": arrays}, SUBMITTED)
    return ids


def resume(sweep: Sweep, numbers: Sequence[int], options: Options = Options()) -> tuple[list[str], list[int]]:
    """Submit the jobs of a sweep that are not queued, so that points, treatments and seeds advance evenly; return
    the arrays' ids, and the jobs that were already queued."""
    waiting = queued_jobs(jobs := jobs_of(sweep), len(sweep.jobs))
    missing = sweep.evenly([n for n in numbers if n not in waiting])
    return submit_jobs(jobs, missing, options) if missing else [], [n for n in numbers if n in waiting]


def queued_jobs(own: Jobs, n: int = 0) -> set[int]:
    """Return the numbers of queued and running jobs; notes of earlier versions require the number of jobs."""
    jobs = {
        array["id"]: array.get("jobs") or range(array.get("offset", 0), n) for array in _arrays(own.place)
    }
    if not jobs:
        return set()
    lines = _slurm(
        "squeue", "--noheader", "--array", f"--user={os.getuid()}", f"--name={own.name}", "--format=%F %K"
    ).splitlines()
    words = [line.split() for line in lines]
    return {jobs[one[0]][int(one[1])] for one in words if one and one[0] in jobs}


def script(jobs: Jobs, numbers: Sequence[int], options: Options, after: str = "") -> str:
    """Return the batch script of an array, which starts after the array `after` has ended. Raises
    ConfigError if an option contains a line break."""
    logs = str(jobs.place).replace("%", "%%") + "/%A_%a.log"  # SLURM expands %
    wanted = {
        "job-name": jobs.name,
        "array": f"0-{len(numbers) - 1}%{options.limit}",
        "ntasks": 1,
        "cpus-per-task": 1,
        "signal": f"B:TERM@{options.notice}",
        "open-mode": "append",
        "output": logs,
        "dependency": f"afterany:{after}" if after else None,
    }
    for source, word in [("DIR", str(jobs.place)), *(("--sbatch", word) for word in options.more)]:
        if not word.isprintable():
            raise refusal(
                (), "cannot be a line of a batch script", word, "printable characters", source=source
            )
    lines = [
        "--requeue",
        *(shlex.quote(f"--{key}={value}") for key, value in wanted.items() if value is not None),
        *options.more,
    ]
    return SCRIPT.format(
        options="\n".join(f"#SBATCH {line}" for line in lines),
        jobs=" ".join(map(str, numbers)),
        unfinished=UNFINISHED,
        pins="export " + " ".join(f"{name}=1" for name in PINS),
        command=shlex.join(jobs.command),
    )


def jobs_of(sweep: Sweep) -> Jobs:
    """Return the jobs of a sweep."""
    own = "from ecs_eco.cli import main; sys.argv[0] = 'ecs-eco'; main()"
    command = python(own, "sweep", "job", str(sweep.folder))
    return Jobs(f"ecs-eco-{sweep.hash[:8]}", inside(sweep.folder, sweep.folder / FOLDER), command)


def _arrays(place: Path) -> list[dict[str, Any]]:
    """Return previously submitted arrays. Raises RecordingError if their record is damaged."""
    if not (place / SUBMITTED).exists():
        return []
    return list(read_sealed(place, SUBMITTED, _Submitted)["arrays"])


class _Array(Section):
    id: Annotated[str, Field(pattern=r"^[0-9]+$")]
    jobs: list[Tick] = []
    offset: Tick = 0  # in earlier versions, which had no `jobs`: a job's number is its task's index + offset
    indices: str = ""  # in earlier versions


class _Submitted(Section):
    arrays: list[_Array]


def _slurm(*command: str) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    except FileNotFoundError:
        allowed = "a machine that can submit jobs, or --on local"
        raise refusal(
            (), f"SLURM is not available: there is no {command[0]}", "slurm", allowed, source="--on"
        ) from None
    if done.returncode != 0:
        why = " ".join((done.stderr or done.stdout).split())
        raise refusal(
            (),
            f"{command[0]} refused: {why}",
            shlex.join(command[1:]),
            "an option that this cluster allows",
            source="--on slurm",
        )
    return done.stdout
