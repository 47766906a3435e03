"""Division of a world among many processes, each of which has built the same world."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ecs_eco.bands.bands import LEAST, Bands, mpi
from ecs_eco.bands.divided import Divided
from ecs_eco.bands.widths import require_divisible

if TYPE_CHECKING:
    from mpi4py.MPI import Comm

    from ecs_eco.ecosystem import World


def divide(world: World, comm: Comm | None = None, least: int = LEAST, *, state: bool = False) -> Any:
    """Divide the work of a world among the processes of an MPI communicator (None: all processes).

    Each process must have built the same world, from the same configuration and seed, and run the same number
    of ticks: then `digest()` is the same in all of them, and equal to that of a single process. Work on
    species of fewer than `least` organisms is repeated in every process. With `state`, each process keeps
    only its part of the world (`ecs_eco.bands.divided`); otherwise all keep the whole world. Returns the
    bands. Raises RuntimeError for worlds that differ, ConfigError for a state that cannot be divided so.
    """
    comm = mpi().COMM_WORLD if comm is None else comm
    bands: Any = Bands(world, comm, least)
    if state:
        widths = require_divisible(world, bands.size)
    if len(digests := set(comm.allgather(world.digest()))) > 1:
        raise RuntimeError(
            f"world {world.name!r}: {comm.Get_size()} processes have {len(digests)} different "
            f"worlds ({', '.join(sorted(d[:200] for d in digests))}); build the same world in "
            "each: configuration, seed, policies, learn"
        )
    if state:
        bands = Divided(world, comm, widths)
    world.bands = bands

    def stop_together() -> None:
        if bands.agree():
            world.stopping = True

    world.before_tick.append(stop_together)
    return bands
