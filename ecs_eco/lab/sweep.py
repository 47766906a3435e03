"""A whole sweep on an executor: training runs precede the jobs that need them, and lost jobs are repeated. Its
progress is read from its folder: finished, running, queued and failed jobs, speed and errors."""

import math
import socket
import time
from bisect import insort
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from statistics import fmean, median
from typing import Any

from ecs_eco.engine.arguments import called_with
from ecs_eco.engine.errors import ConfigError, RecordingError
from ecs_eco.engine.files import read_note
from ecs_eco.lab.design import design_of
from ecs_eco.lab.executors import LOCAL, engine, prepare
from ecs_eco.lab.folder import FAILED, PROGRESS, Sweep, begin
from ecs_eco.lab.jobs import is_trained, read_done, run_job, train
from ecs_eco.lab.plan import read_plan
from ecs_eco.lab.work import Work
from ecs_eco.record.claim import owner_of

Task = int | str  # number of a job, or name of a training run


@dataclass
class Outcome:
    """The outcome of the requested jobs."""

    done: list[int] = field(default_factory=list)
    failed: dict[int, str] = field(default_factory=dict)
    retried: int = 0  # calls that were repeated because their worker was lost

    @property
    def whole(self) -> bool:
        return not self.failed


def run_sweep(
    plan: str | Path | Mapping[str, Any],
    folder: str | Path,
    *,
    executor: Executor | str = LOCAL,
    workers: int | None = None,
    progress: Callable[[Outcome], None] | None = None,
    trust: bool = False,
) -> Outcome:
    """Run all jobs of a plan in a folder, or resume them there.

    Parameters
    ----------
    plan : str, Path or Mapping
        A plan file or its contents, whose `world` can also be a dict or a WorldConfig; see
        docs/how-to/clusters.md.
    folder : str or Path
    executor : str or Executor, default "local"
        "local" (`workers` processes), "ray", or any `concurrent.futures.Executor` whose processes can access
        the folder, such as Dask's `client.get_executor()` or mpi4py's `MPIPoolExecutor()`.
    workers : int, optional
        Number of processes; default: 2, or all CPUs of a Ray cluster.
    progress : callable, optional
        Function called with the outcome after each job.
    trust : bool, default False
        Whether code listed in the world file can run.

    Returns
    -------
    Outcome
        The jobs that are done and those that failed; a failed job does not stop the other jobs.

    Raises
    ------
    ConfigError
        If the plan is invalid.
    ForeignFile
        If the folder contains another sweep.

    Examples
    --------
    >>> from ecs_eco.lab import run_sweep
    >>> plan = {
    ...     "world": "predator-prey",
    ...     "ticks": 10,
    ...     "world_seeds": 2,
    ...     "grid": {"species.deer.metabolism.basal": [0.004, 0.008]},
    ... }
    >>> outcome = run_sweep(plan, "swept", workers=1)
    >>> len(outcome.done)
    4
    """
    called_with("progress", progress, "the outcome")
    sweep = begin(Path(folder), design_of(read_plan(plan), trust=trust))
    with engine(executor, workers) as pool:
        return do_jobs(sweep, pool, progress=progress)


def unfinished(sweep: Sweep) -> list[int]:
    """Return the numbers of unfinished jobs."""
    return [job.number for job in sweep.jobs if read_done(sweep, job.number) is None]


def do_jobs(
    sweep: Sweep,
    executor: Executor,
    numbers: Sequence[int] | None = None,
    *,
    progress: Callable[[Outcome], None] | None = None,
) -> Outcome:
    """Run the jobs with these numbers (default: all unfinished jobs), and return the outcome. On a `Pool`, jobs
    whose worker was killed are repeated here; other executors repeat them themselves."""
    numbers = unfinished(sweep) if numbers is None else numbers
    if numbers:
        prepare(executor, sweep.folder, sweep.base)
    outcome, folder = Outcome(), str(sweep.folder)
    names = dict.fromkeys(sweep.jobs[number].training for number in numbers)
    untrained = {name: "" for name in names if name and not is_trained(*sweep.training(name))}
    allowed = [source.sha256 for source in sweep.base._code.sources if sweep.base._code.allowed]
    with Work[Task](executor) as work:
        for name in untrained:
            work.add(name, train, folder, name, allowed)
        for number in sweep.evenly(numbers):
            name = sweep.jobs[number].training or ""
            work.add(number, run_job, folder, number, allowed, after=name if name in untrained else None)
        for task, future in work:
            why = _failure(future, work.lost[task])
            if isinstance(task, str):
                untrained[task] = "" if why is None else f"its training failed: {why}"
            elif why is None:
                insort(outcome.done, task)
            else:
                outcome.failed[task] = untrained.get(sweep.jobs[task].training or "") or why
            outcome.retried = work.repeated
            if progress is not None:
                progress(outcome)
    return outcome


def _failure(future: Future[Any], lost: int) -> str | None:
    """Return why a call failed, or None if it succeeded; `lost` is the number of times its worker was killed."""
    try:
        future.result()
    except BrokenExecutor as error:
        if lost:
            return f"its worker was killed {lost} times (out of memory?)"
        return f"its worker was lost: {error}"
    except (Exception, CancelledError) as error:
        return f"{type(error).__name__}: {error}"
    return None


RECENT = 5  # finished jobs from which the number of jobs at a time is estimated
ENOUGH = 5.0  # [s] that a job must have run before its rate counts
SILENCE = 600.0  # [s] without a progress record after which a job on another machine counts as lost


@dataclass
class Status:
    """The state of a sweep: job numbers by state, ticks and their rate."""

    done: list[int] = field(default_factory=list)
    running: list[int] = field(default_factory=list)
    waiting: list[int] = field(default_factory=list)
    failed: dict[int, str] = field(default_factory=dict)
    jobs: int = 0
    ticks: int = 0  # completed ticks of all runs
    ticks_in_all: int = 0
    rates: list[float] = field(default_factory=list)  # rates of running jobs, if known [ticks/s]
    each: float = 0.0  # time of a job, from finished jobs, or 0 if none is finished [s]
    left: float = 0.0  # time that the running jobs still need, if a job's time is known [s]
    at_once: float = 1.0  # number of jobs at a time

    @property
    def rate(self) -> float:
        """Return the total ticks per second of running jobs, from the known rates, or 0 if none are known."""
        return len(self.running) * sum(self.rates) / len(self.rates) if self.rates else 0.0

    @property
    def remaining(self) -> float | None:
        """Return the remaining seconds, from the time of finished jobs or the rate of running jobs, if known."""
        if self.each:
            return (len(self.waiting) * self.each + self.left) / self.at_once
        return (self.ticks_in_all - self.ticks) / self.rate if self.rate else None

    def errors(self) -> list[tuple[str, list[int]]]:
        """Return the errors, most frequent first, with the jobs that had them."""
        return [
            (text, [number for number, own in self.failed.items() if own == text])
            for text, _ in Counter(self.failed.values()).most_common()
        ]


class Survey:
    """Surveys a sweep repeatedly, reading finished jobs only once."""

    def __init__(self, sweep: Sweep) -> None:
        self.sweep = sweep
        self._done: dict[int, Mapping[str, Any]] = {}

    def look(self) -> Status:
        sweep, status = self.sweep, Status(jobs=len(self.sweep.jobs))
        status.ticks_in_all = sweep.ticks * status.jobs
        for number in {*range(status.jobs)} - self._done.keys():
            with suppress(RecordingError, ConfigError):
                if (done := read_done(sweep, number)) is not None:
                    self._done[number] = done
        status.done = sorted(self._done)
        status.ticks = sweep.ticks * len(status.done)
        status.each = _each(self._done.values())
        for number in sorted({*range(status.jobs)} - self._done.keys()):
            _look_at(status, number, sweep)
        status.at_once = max(1.0, len(status.running), _at_once(self._done.values()))
        seconds = sum(done["seconds"] for done in self._done.values())
        if not status.rates and seconds:  # all running jobs have just begun
            status.rates.append(sweep.ticks * len(status.done) / seconds)
        return status


def _each(done: Collection[Mapping[str, Any]]) -> float:
    """Return a job's mean time for ticks, plus the median of all other time, as only the first jobs compile."""
    if not done:
        return 0.0
    other = median(max(0.0, one["ended"] - one["began"] - one["seconds"]) for one in done)
    return fmean(one["seconds"] for one in done) + other


def _at_once(done: Collection[Mapping[str, Any]]) -> float:
    """Return how many of the jobs that finished last ran at a time, on average."""
    recent = sorted((one["ended"], one["began"]) for one in done)[-RECENT:]
    span = recent[-1][0] - min(began for _, began in recent) if recent else 0.0
    return sum(ended - began for ended, began in recent) / span if span > 0 else 1.0


def _look_at(status: Status, number: int, sweep: Sweep) -> None:
    place = sweep.job_folder(number)
    note, owner = _numbers(place / PROGRESS), owner_of(place)
    ticks = int(note.get("done", 0))
    status.ticks += ticks
    silent = time.time() - note.get("at", 0.0) > SILENCE
    if owner is not None and (owner.get("host") == socket.gethostname() or not silent):
        status.running.append(number)
        lasted = note.get("at", 0.0) - note.get("began", math.inf)
        rate = (ticks - note.get("from", 0)) / lasted if lasted >= ENOUGH else None
        status.rates += [] if rate is None else [rate]
        left = sweep.ticks - ticks
        status.left += left / rate if rate else status.each * left / sweep.ticks
    elif failure := read_note(place / FAILED):
        status.failed[number] = f"{failure.get('error')}: {failure.get('text')}"
    else:
        status.waiting.append(number)


def _numbers(path: Path) -> dict[str, float]:
    """Return the numbers in a record, ignoring everything else."""
    return {
        key: value
        for key, value in read_note(path).items()
        if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e15
    }
