"""A whole sweep on an executor: training runs precede the jobs that need them, and lost jobs are repeated."""

from bisect import insort
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ecs_eco.engine.arguments import called_with
from ecs_eco.lab.design import design_of
from ecs_eco.lab.executors import LOCAL, engine, prepare
from ecs_eco.lab.folder import Sweep, begin
from ecs_eco.lab.jobs import read_done, run_job, train
from ecs_eco.lab.plan import read_plan
from ecs_eco.lab.trained import is_trained
from ecs_eco.lab.work import Work

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
        Number of processes.
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
