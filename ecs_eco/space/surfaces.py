"""The nearest body of a kind, by distance between surfaces, for worlds in which some bodies are capsules or
boxes."""

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.engine.random import lot
from ecs_eco.space.bodies import solids
from ecs_eco.space.geometry import Extent
from ecs_eco.space.nearest import Found
from ecs_eco.space.shapes import bounds, touching
from ecs_eco.space.solids import Solids, around

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def nearest_surface(
    world: "SpatialWorld", table: "Table", other: "Table", reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return, for each member of a table in the order of its index, the entry of the nearest member of
    another table in that table's index, i32[n] (−1: none within `reach` [m]), and the squared distance f32[n]
    [m^2], 0 for bodies that touch."""
    mine, theirs, space = solids(world, [table.name]), solids(world, [other.name]), world.space
    target, distance2 = np.full(mine.uid.size, -1, np.int32), np.full(mine.uid.size, np.inf, np.float32)
    reached = np.float32(reach)
    world.split(seek_surface, mine.uid.size, mine, theirs, space.extent, reached, Found(target, distance2))
    return target, distance2


@njit
def seek_surface(
    first: int, last: int, mine: Solids, theirs: Solids, space: Extent, reach: np.float32, found: Found
) -> None:
    """Run `nearest_surface` for entries first … last − 1; the nearest of several overlapping bodies is the
    one with the deepest overlap, and ties are broken by a hash of both uids."""
    form, uid, other, other_uid = mine.form, mine.uid, theirs.form, theirs.uid
    near, seen = np.empty(len(other), np.int64), np.zeros(len(other) + 1, np.int64)
    for i in range(first, last):
        x, y, z = np.float64(form[i, 0]), np.float64(form[i, 1]), np.float64(form[i, 2])
        ex, ey, ez = bounds(form, i)
        best, it = np.float64(reach), -1
        n = around(x, y, z, ex + reach, ey + reach, ez + reach, theirs, space, seen, near)
        for q in range(n):
            e = near[q]
            if other_uid[e] == uid[i]:
                continue
            gap, _, _, _ = touching(
                form, i, other, e, x - other[e, 0], y - other[e, 1], z - other[e, 2], space
            )
            if gap < best or (
                gap == best and (it < 0 or lot(0, uid[i], other_uid[e]) < lot(0, uid[i], other_uid[it]))
            ):
                best, it = gap, e
        if it >= 0:
            found.entry[i], found.distance2[i] = it, max(best, 0.0) ** 2
