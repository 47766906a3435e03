"""Engines that carry out calls, each an executor of `concurrent.futures`: `local` uses processes of this
machine, `ray` a Ray cluster. Any other, such as Dask's or mpi4py's, must use processes, since a world
belongs to one thread."""

from __future__ import annotations

from concurrent.futures import Executor
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from ecs_eco.engine.errors import listed, nearest, refusal

if TYPE_CHECKING:
    from ecs_eco.config import WorldConfig

LOCAL, RAY, SLURM = "local", "ray", "slurm"
ENGINES = (LOCAL, RAY, SLURM)
WORKERS = 2  # local processes, by default
TICKS = 40  # of a run that compiles the kernels of a world, including the first update of most policies


def check_engine(on: str) -> None:
    """Raise ConfigError if there is no such engine."""
    if on not in ENGINES:
        raise refusal((), "no such engine", on, listed(ENGINES), nearest(on, ENGINES), "--on")


def executor(on: str = LOCAL, workers: int | None = None) -> Executor:
    """Return an executor on an engine, to be used in a `with` statement.

    By default, `local` has two `workers`, and `ray` all CPUs of its cluster. Raises ConfigError: no such
    engine; Ray is not installed, or its cluster does not answer; `slurm`, which takes whole sweeps only.
    """
    check_engine(on)
    if on == SLURM:
        allowed = (
            "local, ray; SLURM runs sweeps, `ecs-eco sweep PLAN --on slurm`, and any command with "
            "--on local inside your own job"
        )
        raise refusal((), "takes whole sweeps only", on, allowed, source="--on")
    if on == RAY:
        from ecs_eco.lab.ray_executor import RayExecutor

        return RayExecutor(workers)
    from ecs_eco.lab.pool import Pool  # processes, which single runs do not need

    return Pool(workers or WORKERS)


def engine(on: str | Executor = LOCAL, workers: int | None = None) -> AbstractContextManager[Executor]:
    """Return a context of an executor: one created for its block, or the given one, which keeps running.

    If an exception leaves the block, an executor created for it ends at once.
    """
    return nullcontext(on) if isinstance(on, Executor) else executor(on, workers)


def workers_of(pool: Executor) -> int:
    """Return how many calls an executor carries out at a time, by default `WORKERS`."""
    for name in ("workers", "_max_workers", "num_workers"):  # ours, the standard library's, mpi4py's
        if isinstance(number := getattr(pool, name, None), int):
            return max(1, number)
    return WORKERS


def prepare(pool: Executor, folder: Path, config: WorldConfig) -> None:
    """Before many calls on a cluster, check that each machine has the folder, and compile the kernels there.

    Raises ConfigError naming the machines that do not have it. Other executors need no preparation.
    """
    if hasattr(pool, "on_each_machine"):
        pool.on_each_machine(folder.absolute(), compile_kernels, config)


def compile_kernels(config: WorldConfig) -> None:
    """Run a world for some ticks, which leaves its kernels in this machine's cache."""
    from ecs_eco.ecosystem import World

    config._code.pass_on()
    World.from_config(config, seed=1, record=False).run(TICKS)
