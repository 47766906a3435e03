"""Engines that carry out calls, each an executor of `concurrent.futures`: `local` is processes of this
machine, `ray` a Ray cluster. Any other, Dask's or mpi4py's, must use processes, since a world belongs to one
thread."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, as_completed
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest

if TYPE_CHECKING:
    from ecs_eco.config import WorldConfig

LOCAL, RAY, SLURM = "local", "ray", "slurm"
ENGINES = (LOCAL, RAY, SLURM)
WORKERS = 2  # local processes where no number is given
TICKS = 40  # of a world that is run to have its kernels compiled; with the first update of most policies

Key = TypeVar("Key", bound=Hashable)
Result = TypeVar("Result")


def check_engine(on: str, source: str = "--on") -> None:
    """Raise ConfigError where there is no such engine."""
    if on not in ENGINES:
        raise ConfigError([Problem((), "no such engine", on, listed(ENGINES), nearest(on, ENGINES), source)])


def executor(on: str = LOCAL, workers: int | None = None, source: str = "--on") -> Executor:
    """Return an executor on an engine, to be used in a `with` statement.

    Without a number of `workers`, `local` has two, and `ray` all CPUs of its cluster. Raises ConfigError: no
    such engine; Ray is not installed, or its cluster does not answer; `slurm`, which takes whole sweeps only.
    """
    check_engine(on, source)
    if on == SLURM:
        allowed = (
            "local, ray; SLURM runs sweeps, `ecs-eco sweep PLAN --on slurm`, and any command "
            "with --on local inside a job of your own"
        )
        raise ConfigError([Problem((), "takes whole sweeps only", on, allowed, source=source)])
    if on == RAY:
        from ecs_eco.lab.ray_executor import RayExecutor

        return RayExecutor(workers)
    from ecs_eco.lab.pool import Pool  # processes: not for a run of one's own

    return Pool(workers or WORKERS)


@contextmanager
def engine(on: str | Executor = LOCAL, workers: int | None = None) -> Iterator[Executor]:
    """Lend an executor: one made for it and ended with it, or the one given, which is left running.

    Where an exception leaves the block, calls that have not begun are cancelled, and an executor made here
    is ended with all it does.
    """
    if isinstance(on, str):
        with executor(on, workers) as made:
            yield made
        return
    lent = Lent(on, workers)
    try:
        yield lent
    except BaseException:
        lent.terminate()
        raise


class Lent(Executor):
    """An executor that belongs to the user: its end is none of ours, only what was submitted here."""

    def __init__(self, of: Executor, workers: int | None = None) -> None:
        self.of, self.workers = of, workers or workers_of(of)
        self._submitted: set[Future[Any]] = set()

    def submit(self, fn: Callable[..., Result], /, *args: Any, **kwargs: Any) -> Future[Result]:
        """Submit a call to the user's executor."""
        future = self.of.submit(fn, *args, **kwargs)
        self._submitted.add(future)
        future.add_done_callback(self._submitted.discard)
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Leave the executor running."""
        if cancel_futures:
            self.terminate()

    def terminate(self) -> None:
        """Cancel what was submitted here; what has begun goes on where the executor cannot stop it."""
        for future in tuple(self._submitted):
            future.cancel()


def workers_of(pool: Executor) -> int:
    """Return how many calls an executor carries out at a time, `WORKERS` where it does not say."""
    for name in ("workers", "_max_workers", "num_workers"):  # ours, the standard library's, mpi4py's
        if isinstance(number := getattr(pool, name, None), int):
            return max(1, number)
    return WORKERS


def completed(
    pool: Executor, fn: Callable[..., Result], jobs: Mapping[Key, Sequence[Any]]
) -> Iterator[tuple[Key, Future[Result]]]:
    """Call `fn` with the arguments of each job; yield keys with their futures as these are done."""
    from ecs_eco.lab.pool import Pool, done_here

    if isinstance(pool, Pool) and min(pool.workers, len(jobs)) == 1:
        for key, arguments in jobs.items():
            yield key, done_here(fn, arguments, {})
        return
    keys = {pool.submit(fn, *arguments): key for key, arguments in jobs.items()}
    for future in as_completed(keys):
        yield keys[future], future


def terminate(pool: Executor) -> None:
    """End what an executor is doing; one that cannot finishes what it has begun."""
    if hasattr(pool, "terminate"):
        pool.terminate()
    else:
        pool.shutdown(wait=False, cancel_futures=True)


def prepare(pool: Executor, folder: Path, config: WorldConfig) -> None:
    """Before many calls on a cluster: see that each machine has the folder, and compile the kernels there.

    Raises ConfigError naming the machines that do not have it. Other executors need no preparation.
    """
    pool = pool.of if isinstance(pool, Lent) else pool
    if hasattr(pool, "on_each_machine"):
        pool.on_each_machine(folder.absolute(), compile_kernels, config)


def compile_kernels(config: WorldConfig) -> None:
    """Run a world for some ticks, which leaves its kernels in this machine's cache."""
    from ecs_eco.ecosystem import World

    config._code.pass_on()
    World.from_config(config, seed=1, record=False).run(TICKS)
