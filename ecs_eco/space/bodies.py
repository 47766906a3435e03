"""What stands where: the ground that nothing walks into or sees through, and the bodies of several tables in one index."""

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Body, Position
from ecs_eco.space import sight

if TYPE_CHECKING:
    from ecs_eco.ecosystem import World


def rocks(world: "World") -> tuple[np.ndarray, np.ndarray]:
    """Return the ground map and its scale; a map of one cell stands for open ground."""
    if world.terrain is None:
        return sight.NO_GROUND, np.zeros(2, np.float32)
    return world.terrain.ground, world.terrain.inverse


def opaque(world: "World") -> sight.Bodies:
    """Return all bodies that hide what is behind them."""
    return merged(world, [n for n, t in world.tables.items() if Body in t and t.species.opaque is not False])


def merged(world: "World", names: list[str]) -> sight.Bodies:
    """Return the bodies of several tables in one index, rebuilt when one of them has changed."""
    tables = [world.tables[n] for n in names]
    key = tuple(names)
    with world.lock:  # several threads may want it at once
        version = tuple(t.version for t in tables)
        found = world._merged.get(key)
        if found is None or found[0] != version:
            parts = []
            for table in tables:
                rows, p = world.index(table).rows, table[Position]
                parts.append((p.x[rows], p.y[rows], p.z[rows], table[Body].radius[rows], table.uid[rows]))
            found = world._merged[key] = (version, sight.Bodies(world.space, parts))
        return found[1]
