"""Engines, which are `concurrent.futures` executors: `local` for processes on this machine, `ray` for a cluster.
Other executors, such as those of Dask and mpi4py, must use processes: a world is bound to one thread."""

from __future__ import annotations

from concurrent.futures import Executor
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from ecs_eco.engine.errors import listed, nearest, refusal

if TYPE_CHECKING:
    from ecs_eco.config import WorldConfig
    from ecs_eco.ecosystem import World

LOCAL, RAY, SLURM = "local", "ray", "slurm"
ENGINES = (LOCAL, RAY, SLURM)
WORKERS = 2  # default number of local processes
TICKS = 40  # length of a run that compiles a world's kernels, including the first update of most policies


def check_engine(on: str) -> None:
    """Raise ConfigError if the engine is unknown."""
    if on not in ENGINES:
        raise refusal((), "no such engine", on, listed(ENGINES), nearest(on, ENGINES), "--on")


def executor(on: str = LOCAL, workers: int | None = None) -> Executor:
    """Return an engine's executor for use in a `with` statement; by default, `local` has two `workers`, and
    `ray` uses all CPUs of its cluster. Raises ConfigError if the engine is unknown, if Ray is missing or its
    cluster does not answer, and for `slurm`, which runs only whole sweeps."""
    check_engine(on)
    if on == SLURM:
        allowed = (
            "local or ray; SLURM runs sweeps (`ecs-eco sweep PLAN --on slurm`) and, inside your own job, "
            "any command with --on local"
        )
        raise refusal((), "runs only whole sweeps", on, allowed, source="--on")
    if on == RAY:
        from ecs_eco.lab.ray_executor import RayExecutor

        return RayExecutor(workers)
    from ecs_eco.lab.pool import Pool  # imports multiprocessing, which single runs do not need

    return Pool(workers or WORKERS)


def engine(on: str | Executor = LOCAL, workers: int | None = None) -> AbstractContextManager[Executor]:
    """Return a context manager for an executor: a new one, which an exception that leaves the block shuts down
    at once, or the given one, which stays open."""
    return nullcontext(on) if isinstance(on, Executor) else executor(on, workers)


def workers_of(pool: Executor) -> int:
    """Return how many calls an executor runs at a time, or `WORKERS` if this is unknown."""
    for name in ("workers", "_max_workers", "num_workers"):  # ours, the standard library's, mpi4py's
        if isinstance(number := getattr(pool, name, None), int):
            return max(1, number)
    return WORKERS


def prepare(pool: Executor, folder: Path, config: WorldConfig) -> None:
    """Check that a cluster's machines can access the folder, else raise ConfigError; compile kernels there."""
    if hasattr(pool, "on_each_machine"):
        pool.on_each_machine(folder.absolute(), compile_kernels, config)


def compile_kernels(config: WorldConfig) -> None:
    """Run a world for a few ticks to put its kernels in this machine's cache."""
    built(config).run(TICKS)


def built(world: WorldConfig) -> World:
    """Return a world to be examined, which records nothing."""
    from ecs_eco.ecosystem import World

    world._code.pass_on()
    return World.from_config(world, seed=1, record=False)
