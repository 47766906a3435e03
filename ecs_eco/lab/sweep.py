"""A whole sweep on an executor: trainings before the jobs that need them; who is lost is called again."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ecs_eco.engine.arguments import called_with
from ecs_eco.lab.design import design_of
from ecs_eco.lab.executors import LOCAL, engine, prepare
from ecs_eco.lab.folder import Sweep, begin
from ecs_eco.lab.jobs import read_done, run_job, train
from ecs_eco.lab.plan import read_plan
from ecs_eco.lab.pool import Pool
from ecs_eco.lab.trained import is_trained

RETRIES = 5  # how often a job is called again whose worker was killed
Task = int | str  # the number of a job, or the name of a training


@dataclass
class Outcome:
    """What became of the jobs that were asked for."""

    done: list[int] = field(default_factory=list)
    failed: dict[int, str] = field(default_factory=dict)
    retried: int = 0  # calls whose worker was lost

    @property
    def whole(self) -> bool:
        """Whether all are done."""
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
    """Do all jobs of a plan, a file or a dict, into a folder, or go on with them there.

    `executor` is "local", which is `workers` processes, "ray", or any `concurrent.futures.Executor` of
    processes that see the folder: Dask's `client.get_executor()`, mpi4py's `MPIPoolExecutor()`. A job that
    fails stops no other. `trust` allows the code that the world lists to run. Raises ConfigError for a plan
    that is refused, ForeignFile where the folder holds the sweep of another.
    """
    called_with("progress", progress, "the outcome")
    sweep = begin(Path(folder), design_of(read_plan(plan), trust=trust))
    if isinstance(executor, Executor):
        return do_jobs(sweep, executor, progress=progress)
    with engine(executor, workers) as pool:
        return do_jobs(sweep, pool, progress=progress)


def unfinished(sweep: Sweep) -> list[int]:
    """Return the numbers of the jobs that are not done."""
    return [job.number for job in sweep.jobs if read_done(sweep, job.number) is None]


def do_jobs(
    sweep: Sweep,
    executor: Executor,
    numbers: Sequence[int] | None = None,
    *,
    progress: Callable[[Outcome], None] | None = None,
) -> Outcome:
    """Do the jobs with these numbers, or all that are not done; return what became of them.

    On the project's own Pool a job whose worker was killed is called again; other executors do so themselves.
    """
    numbers = unfinished(sweep) if numbers is None else numbers
    if numbers:
        prepare(executor, sweep.folder, sweep.base)
    return _Jobs(sweep, executor, numbers, progress).do()


class _Jobs:
    """Jobs that are ready, that wait for a training, and that run."""

    def __init__(
        self,
        sweep: Sweep,
        executor: Executor,
        numbers: Sequence[int],
        progress: Callable[[Outcome], None] | None,
    ) -> None:
        self.sweep, self.executor, self.progress = sweep, executor, progress
        self.outcome = Outcome()
        self.lost: dict[Task, int] = {}  # how often the worker of a task was
        self.running: dict[Future[Any], Task] = {}
        self.allowed = [s.sha256 for s in sweep.base._code.sources if sweep.base._code.allowed]
        self.waiting: dict[str, list[int]] = {}
        self.ready: deque[Task] = deque()
        for number in numbers:
            training = sweep.jobs[number].training
            if training is None or self._is_trained(training):
                self.ready.append(number)
            else:
                self.waiting.setdefault(training, []).append(number)
        self.ready.extendleft(reversed(self.waiting))

    def _is_trained(self, name: str) -> bool:
        if name in self.waiting:
            return False
        training = self.sweep.trainings[name]
        config = self.sweep.world(training.values, training.treatment).config
        return is_trained(self.sweep.policies_folder(name), config, training.seed)

    def do(self) -> Outcome:
        try:
            while self.ready or self.running:
                self._submit()
                self._take()
                if self.progress is not None:
                    self.progress(self.outcome)
        except BaseException:
            for future in self.running:
                future.cancel()
            raise
        return self.outcome

    def _submit(self) -> None:
        """Submit what is ready: one more than a pool has workers, so that none waits for its next and few are
        lost with a worker."""
        most = self.executor.workers + 1 if isinstance(self.executor, Pool) else len(self.ready)
        while self.ready and len(self.running) < max(1, most):
            task = self.ready.popleft()
            call: Callable[..., Any] = run_job if isinstance(task, int) else train
            future = self.executor.submit(call, str(self.sweep.folder), task, self.allowed)
            self.running[future] = task
            if future.done():
                return

    def _take(self) -> None:
        """Take what is done."""
        done, _ = wait(self.running, return_when=FIRST_COMPLETED)
        broken = False
        for future in done:
            task = self.running.pop(future)
            try:
                future.result()
            except BrokenExecutor as error:
                broken = True
                self._lose(task, error)
            except (Exception, CancelledError) as error:
                self._fail(task, f"{type(error).__name__}: {error}")
            else:
                self._done(task)
        if broken and isinstance(self.executor, Pool):
            for future, task in list(self.running.items()):  # all of them are lost
                self._lose(task, future.exception())
            self.running.clear()
            self.executor.terminate()

    def _done(self, task: Task) -> None:
        if isinstance(task, int):
            self.outcome.done.append(task)
        else:
            self.ready.extend(self.waiting.pop(task))

    def _lose(self, task: Task, error: BaseException | None) -> None:
        """Call a task again whose worker was killed, unless that happened too often."""
        self.lost[task] = self.lost.get(task, 0) + 1
        if not isinstance(self.executor, Pool):
            self._fail(task, f"its worker was lost: {error}")
        elif self.lost[task] > RETRIES:
            self._fail(task, f"its worker was killed {self.lost[task]} times (out of memory?)")
        else:
            self.outcome.retried += 1
            self.ready.append(task)

    def _fail(self, task: Task, why: str) -> None:
        if isinstance(task, int):
            self.outcome.failed[task] = why
            return
        for number in self.waiting.pop(task):
            self.outcome.failed[number] = f"its training failed: {why}"
