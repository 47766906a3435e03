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


Seedlings = tuple["Table", np.ndarray, dict[tuple[type, str], np.ndarray], np.ndarray]
"""Newborns of one table: their parents u64[k], columns and sites u64[k]."""


def root(world: SpatialWorld, seedlings: list[Seedlings]) -> None:
    """Take the substances of newborns from the soil below them, and request those that find everything they
    need. Newborns of all tables take substances in a random order, drawn for their sites."""
    fields, parts = first_fields(world), list[tuple[np.ndarray, ...]]()
    soil = {s: world.fields[fields[name]] for s, name in enumerate(world.substances) if name in fields}
    for table, _, values, site in seedlings:
        molarity, shape = table.defaults[Chemistry]["molarity"], (len(soil), site.size)
        volume = newborn_volumes(
            table, np.broadcast_to(values.get((Body, "radius"), table.defaults[Body]["radius"]), site.size)
        )
        lots = random.bits_of(world.key, site, random.LOT + (1 << 8) + (table.place << 20))
        cell = np.reshape([cells_under(field, values) for field in soil.values()], shape)
        demand = [np.float64(molarity[s]) * volume / field.litres for s, field in soil.items()]
        parts.append((lots, volume, cell, np.reshape(demand, shape)))
    lots, volume, cell, wanted = (np.concatenate(part, -1) for part in zip(*parts, strict=True))
    order, rooted = np.argsort(lots), np.ones(lots.size, np.bool_)
    if soil:
        rooted[order] = claim(
            cell[:, order], wanted[:, order], tuple(field.value.reshape(-1) for field in soil.values())
        )
    ends = np.cumsum([site.size for *_, site in seedlings])[:-1]
    shares = np.split(rooted, ends), np.split(volume, ends)
    for (table, parents, values, _), grows, each in zip(seedlings, *shares, strict=True):
        taken, needed = np.zeros(len(world.substances)), list(soil)
        taken[needed] = table.defaults[Chemistry]["molarity"][needed].astype(np.float64) * each[grows].sum()
        book(world, table, "taken_up", taken)
        book(world, table, "endowed", -taken)  # because the birth records it again
        for s in needed if world.matter is not None else ():
            world.matter.book(("field", fields[world.substances[s]]), "taken_up", -taken[s], s)
        table.request(parents[grows], {name: some[grows] for name, some in values.items()})


def cells_under(field: Any, values: Mapping[tuple[type, str], np.ndarray]) -> np.ndarray:
    """Return the index of a field's cell at each position: i64[k]."""
    nx, ny, nz = field.shape
    i, j, k = (
        cells_of(values[Position, axis], field.inverse[q], n)
        for q, (axis, n) in enumerate(zip("xyz", (nx, ny, nz), strict=True))
    )
    return (k * ny + j) * nx + i


@njit
def claim(cell, wanted, soil):
    """Give each of k newborns, in order, either its whole demand from its soil cells or nothing; return which
    get theirs, bool[k]."""
    rooted = np.ones(cell.shape[1], np.bool_)
    for i in range(rooted.size):
        for k in range(len(soil)):
            if soil[k][cell[k, i]] < wanted[k, i]:
                rooted[i] = False
        for k in range(len(soil)):
            if rooted[i]:
                soil[k][cell[k, i]] -= wanted[k, i]
    return rooted
