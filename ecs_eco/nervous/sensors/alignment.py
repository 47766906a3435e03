"""The sensor for the heading of neighbors, by which animals in a group align."""

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.elementary import arrays
from ecs_eco.components import Position
from ecs_eco.nervous.sensors.sense import Sense, own_range
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.sums import NONE, add_near

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def feel_alignment(target: str, radius: float, number: int = 0) -> Sense:
    """Sense the mean heading of the members of a species within `radius` [m], in the body's frame: the means of
    the cosine and sine of the difference from the own heading, both 0 without neighbors."""

    def read(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        other, mine = world.tables[target], seekers.index
        targets, (_, own) = world.index(other), own_range(table, seekers, number, radius)
        heading = other[Position].heading[targets.rows]
        size, places = np.zeros(targets.n, np.float32), (mine.x, mine.y, mine.z)
        (east, n), (north, _) = sums = np.zeros((2, 2, seekers.n))
        for axis, (total, weight) in zip((arrays.cos(heading), arrays.sin(heading)), sums, strict=True):
            add_near(mine, places, own, targets, axis, size, NONE, total, weight, world.split)
        n = np.maximum(n, 1)
        out[:, column] = (east * seekers.cos + north * seekers.sin) / n
        out[:, column + 1] = (north * seekers.cos - east * seekers.sin) / n

    return Sense(read)
