"""Obstacles: ground that nothing can enter or see through, and the bodies of several tables in one index."""

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Body, Position
from ecs_eco.space import sight

if TYPE_CHECKING:
    from ecs_eco.space.world import SpatialWorld


def rocks(world: "SpatialWorld") -> tuple[np.ndarray, np.ndarray]:
    """Return the ground map and its scale; a map of one cell stands for open ground."""
    if world.terrain is None:
        return sight.NO_GROUND, np.zeros(2, np.float32)
    return world.terrain.ground, world.terrain.inverse


def opaque(world: "SpatialWorld") -> sight.Bodies:
    """Return all bodies that hide what is behind them."""
    return merged(world, [n for n, t in world.tables.items() if Body in t and t.species.opaque is not False])


def merged(world: "SpatialWorld", names: list[str]) -> sight.Bodies:
    """Return the bodies of several tables in one index, rebuilt when one of them has changed."""

    def build() -> sight.Bodies:
        parts = []
        for table in (world.tables[name] for name in names):
            rows, p = world.index(table).rows, table[Position]
            parts.append((p.x[rows], p.y[rows], p.z[rows], table[Body].radius[rows], table.uid[rows]))
        return sight.Bodies(world.space, parts)

    return world.merged(tuple(names), build)
