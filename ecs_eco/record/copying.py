"""Copies of a living world: frozen and restored in memory, as by a checkpoint."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from ecs_eco.engine.arguments import seed_number
from ecs_eco.engine.errors import CheckpointError
from ecs_eco.inputs.section import Use, function_name
from ecs_eco.life.reconfigure import reseed
from ecs_eco.record import freeze as frozen
from ecs_eco.record.recorder import Recorder

if TYPE_CHECKING:
    from ecs_eco.space.world import SpatialWorld


def copy(
    world: SpatialWorld,
    *,
    threads: int | None = None,
    systems: Sequence[Any] = (),
    prepare: Callable[[Any], None] | None = None,
) -> Any:
    """Return a world with its own organisms, policies and clock, the same digest, and the same future.

    Arguments and errors are the same as for `ecs_eco.World.copy`.
    """
    where = f"copy of the world {world.name!r}"
    meta, arrays = frozen.freeze(world)
    arrays = {name: array.copy() for name, array in arrays.items()}
    meta = json.loads(json.dumps(meta))
    if meta["config"] is None:
        raise CheckpointError(
            f"{where}: it was built by hand; build another in the same way, then call world.save(path) and "
            "other.load(path)"
        )
    handed = [s for s in world.config.systems if not isinstance(s, str | type | Use)]
    if handed and not systems:
        raise CheckpointError(
            f"{where}: the system {function_name(handed[0])} was passed as an instance, which belongs to "
            "one world; pass another: world.copy(systems=[…])"
        )
    config = None if handed else world.config
    made = frozen.thaw(
        type(world), meta, world.threads if threads is None else threads, config, systems, where
    )
    made.reporters = {**world.reporters, **made.reporters}  # including tables that were added by hand
    if prepare is not None:
        prepare(made)
    if world.recorder is not None:
        Recorder(made)
    frozen.load(made, meta, arrays, where)
    return made


def fork(world: SpatialWorld, seed: int, **how: Any) -> Any:
    """Return a copy with another seed; arguments and errors are the same as for `ecs_eco.World.fork`."""
    seed = seed_number(seed)
    made = copy(world, **how)
    reseed(made, seed)
    return made
