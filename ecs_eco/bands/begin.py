"""Divide a world among processes that have each built the same world."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ecs_eco.bands.bands import LEAST, Bands, mpi
from ecs_eco.bands.divided import Divided
from ecs_eco.bands.widths import require_divisible

if TYPE_CHECKING:
    from mpi4py.MPI import Comm

    from ecs_eco.ecosystem import World


def divide(world: World, comm: Comm | None = None, least: int = LEAST, *, state: bool = False) -> Any:
    """Share the work of a world with the other processes of an MPI communicator.

    Parameters
    ----------
    world : World
        Every process must have built the same world, from the same configuration and seed, and must run the
        same ticks.
    comm : mpi4py.MPI.Comm, optional
        Default: all processes.
    least : int, default 64
        Species with fewer organisms than this are computed by every process.
    state : bool, default False
        Whether each process holds only its own part of the world instead of all of it.

    Returns
    -------
    Bands or Divided

    Raises
    ------
    RuntimeError
        If the processes have built different worlds.
    ConfigError
        If the state of this world cannot be divided into this many bands, or cannot be divided at all.

    Notes
    -----
    `world.digest()` is the same in all processes and equals the digest of a single-process run.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.bands import divide
    >>> world = World.from_config("predator-prey", seed=1)
    >>> bands = divide(world)  # doctest: +SKIP
    """
    comm = mpi().COMM_WORLD if comm is None else comm
    bands: Any = Bands(world, comm, least)
    if state:
        widths = require_divisible(world, bands.size)
    if len(digests := set(comm.allgather(world.digest()))) > 1:
        raise RuntimeError(
            f"world {world.name!r}: {comm.Get_size()} processes have {len(digests)} different "
            f"worlds ({', '.join(sorted(d[:200] for d in digests))}); build the same world in "
            "each process, with the same configuration, seed, policies and learn"
        )
    if state:
        bands = Divided(world, comm, widths)
    world.bands = bands

    def stop_together() -> None:
        if bands.agree():
            world.stopping = True

    world.before_tick.append(stop_together)
    return bands
