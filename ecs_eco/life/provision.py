"""The substances that seeds need from the soil to sprout."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Body, Chemistry, Position
from ecs_eco.engine import random
from ecs_eco.life.matter import book, first_fields, newborn_volumes
from ecs_eco.space.geometry import cells_of

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def root(
    world: SpatialWorld, table: Table, values: Mapping[tuple[type, str], np.ndarray], site: np.ndarray
) -> np.ndarray:
    """Take the substances of newborns with these columns from the soil below them; return which newborns find
    everything they need, bool[k]. Newborns take substances in a random order, drawn for their sites u64[k]."""
    molarity, fields = table.defaults[Chemistry]["molarity"], first_fields(world)
    needed = [s for s, name in enumerate(world.substances) if molarity[s] > 0 and name in fields]
    n = values[Position, "x"].size
    radius = np.broadcast_to(values.get((Body, "radius"), table.defaults[Body]["radius"]), n)
    volume = newborn_volumes(table, radius)
    rooted = np.ones(n, np.bool_)
    if not needed:
        return rooted
    cell, wanted, soil = np.empty((n, len(needed)), np.int64), np.empty((n, len(needed))), []
    for k, s in enumerate(needed):
        field = world.fields[fields[world.substances[s]]]
        cell[:, k] = cells_under(field, values)
        wanted[:, k] = np.float64(molarity[s]) * volume / field.litres
        soil.append(field.value.reshape(-1))
    order = random.by_lot(world.key, site, random.LOT + (1 << 8) + (table.place << 20))
    claim(cell[order], wanted[order], tuple(soil), rooted)
    rooted[order] = rooted.copy()
    taken = np.zeros(len(world.substances))
    taken[needed] = molarity[needed].astype(np.float64) * volume[rooted].sum()
    book(world, table, "taken_up", taken)
    book(world, table, "endowed", -taken)  # because the birth records it again
    for s in needed if world.matter is not None else ():
        world.matter.book(("field", fields[world.substances[s]]), "taken_up", -taken[s], s)
    return rooted


def cells_under(field: Any, values: Mapping[tuple[type, str], np.ndarray]) -> np.ndarray:
    """Return the index of a field's cell at each position: i64[k]."""
    nx, ny, nz = field.shape
    i, j, k = (
        cells_of(values[Position, axis], field.inverse[q], n)
        for q, (axis, n) in enumerate(zip("xyz", (nx, ny, nz), strict=True))
    )
    return (k * ny + j) * nx + i


@njit
def claim(cell, wanted, soil, rooted):
    """Give each of k newborns, in order, either its whole demand from its soil cells or nothing."""
    for i in range(rooted.size):
        for k in range(len(soil)):
            if soil[k][cell[i, k]] < wanted[i, k]:
                rooted[i] = False
        for k in range(len(soil)):
            if rooted[i]:
                soil[k][cell[i, k]] -= wanted[i, k]
