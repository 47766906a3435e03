"""Run in bands: process 0 records the run, and the other processes run the same ticks in lockstep."""

from __future__ import annotations

import os
import sys
import time
import traceback
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ecs_eco.bands.bands import mpi
from ecs_eco.bands.begin import divide
from ecs_eco.engine.errors import CheckpointError, ConfigError, RecordingError
from ecs_eco.runs.signals import stopping

if TYPE_CHECKING:
    from mpi4py.MPI import Comm

    from ecs_eco.ecosystem import World

GRACE = 5.0  # [s] time for process 0 to report an error first, because most errors occur in all processes
HEARD = 1.0  # [s] time for mpiexec to forward the output of a process before all processes end
PLAIN = (ConfigError, CheckpointError, RecordingError, FloatingPointError, OSError)  # need no traceback


def together(
    lead: Callable[[Callable[[Any], None]], Any],
    build: Callable[[], World],
    ticks: int | None,
    comm: Comm | None = None,
    *,
    state: bool = False,
) -> tuple[Any, Any] | None:
    """Run one world on the processes of an MPI communicator (default: all processes).

    In process 0, `lead(prepare)` runs a world to tick `ticks` (None: the `ticks` of its file) and calls
    `prepare(world)` before the first tick, like `runs.run.run_to_folder`. In the other processes, `build()`
    returns the same world. With `state`, each process holds only a part of that world. Returns the result of
    `lead` and the bands in process 0, and None in the other processes. An error in one process ends all
    processes with exit code 1, or 2 for an invalid file. Raises a RuntimeError if each process holds the
    whole world and these worlds differ at the end."""
    comm = mpi().COMM_WORLD if comm is None else comm
    led: list[World] = []

    def prepare(world: World) -> None:
        led.append(world)
        divide(world, comm, state=state)

    try:
        if comm.Get_rank():
            _follow(_built(build, comm), ticks, comm, state)
            return None
        result = lead(prepare)
        return result, _agreed(led[0], comm)
    except BaseException as error:
        if led and led[0].stopped and led[0].underway is None:
            _end_of(led[0])
            raise  # the run was asked to stop
        _end_all(error, comm)
        raise


def _built(build: Callable[[], World], comm: Comm) -> World:
    """Build the world in a process other than 0. Process 0 reports errors first, because most occur there,
    too."""
    try:
        return build()
    except Exception as error:
        comm.allgather(f"no world ({error})")
        raise


def _follow(world: World, ticks: int | None, comm: Comm, state: bool) -> None:
    divide(world, comm, state=state)
    with stopping(world):
        world.run((ticks or world.config.ticks) - world.tick)
    if state:
        bands: Any = world.bands
        bands.talk.serve()
    else:
        _agreed(world, comm)


def _end_of(world: World) -> None:
    """Tell waiting processes that the run has ended."""
    bands: Any = world.bands
    if bands.divided:
        bands.talk.end()


def _agreed(world: World, comm: Comm) -> Any:
    """Return the bands of a world; raise a RuntimeError if the worlds of the processes differ."""
    _end_of(world)
    if world.bands.divided:
        return world.bands
    digests = [] if world.stopped else comm.allgather(world.digest())  # a stop leaves no time to compare
    if len(set(digests)) > 1:
        raise RuntimeError(
            f"world {world.name!r}: the worlds of the processes differ at tick "
            f"{world.tick}: {', '.join(d[:12] for d in digests)}; a system or sensor of this "
            "world gives different results in different processes"
        )
    return world.bands


def _end_all(error: BaseException, comm: Comm) -> None:
    """Report an error and end all processes, because the others would wait forever for this one."""
    if comm.Get_size() == 1:
        return
    if comm.Get_rank():
        time.sleep(GRACE)
    text = str(error) if isinstance(error, PLAIN) else "".join(traceback.format_exception(error))
    print(f"process {comm.Get_rank()} of {comm.Get_size()}: {text}", file=sys.stderr, flush=True)
    time.sleep(HEARD)
    code = 2 if isinstance(error, ConfigError) else 1
    comm.Abort(code)
    os._exit(code)  # some libraries return from Abort before the process has ended
