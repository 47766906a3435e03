"""Doses: amounts that people add to fields and bodies, or remove from them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Chemistry, Position
from ecs_eco.engine.errors import UnknownName, unknown_name
from ecs_eco.life.matter import Bodies, bodies, held, hold
from ecs_eco.space.geometry import cells_of

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.region import Region
    from ecs_eco.space.world import SpatialWorld

BROUGHT = "brought_in"


def dose_field(world: SpatialWorld, name: str, amount: float, region: Region | None) -> None:
    """Distribute an amount [mol] evenly over the cells of a field whose centers are in a region, or over all
    cells. If the region contains no cell center, the cell at its middle gets everything. No cell falls below
    0.

    For a smell without a substance, the amount is in the smell's own unit. Raises UnknownName for an unknown
    field.
    """
    if name not in world.fields:
        raise UnknownName(unknown_name("dose", "field", name, world.fields))
    field = world.fields[name]
    litres = field.litres if field.substance is not None else 1.0
    columns = _columns(field, region)
    cells = field.value[:, columns]
    after = np.maximum(cells + amount / (cells.size * litres), 0).astype(cells.dtype)
    field.value[:, columns] = after
    if field.substance is not None and world.matter is not None:
        brought = float((after - cells).sum()) * litres
        world.matter.book(("field", name), BROUGHT, brought, world.substances.index(field.substance))


def dose_bodies(
    world: SpatialWorld, table: Table, substance: str, amount: float, region: Region | None
) -> None:
    """Add an amount [mol] of a substance to each living body of a table in a region, or remove up to the
    body's content."""
    if substance not in world.substances or Chemistry not in table:
        raise UnknownName(
            unknown_name(
                f"dose {table.name}", "substance", substance, world.substances if Chemistry in table else []
            )
        )
    s, rows = world.substances.index(substance), table.by_uid()
    if region is not None:
        p = table[Position]
        rows = rows[region.has(p.x[rows], p.y[rows])]
    brought = give(rows, bodies(table), s, amount)
    if world.matter is not None:
        world.matter.book(("table", table.name), BROUGHT, brought, s)


def _columns(field: Any, region: Region | None) -> np.ndarray:
    """Return which columns of a field's cells are in a region: bool[ny, nx]."""
    nx, ny = field.shape[:2]
    inside = np.ones((ny, nx), np.bool_)
    if region is None:
        return inside
    x, y = (np.arange(nx) + 0.5) / field.inverse[0], (np.arange(ny) + 0.5) / field.inverse[1]
    inside = region.has(*np.meshgrid(x, y))
    if not inside.any():
        middle = region.numbers[:2] if region.round else np.add(region.numbers[:2], region.numbers[2:]) / 2
        i, j = (
            int(cells_of(np.array([at]), field.inverse[axis], n)[0])
            for axis, (at, n) in enumerate(zip(middle, (nx, ny), strict=True))
        )
        inside[j, i] = True
    return inside


@njit
def give(rows: np.ndarray, bodies: Bodies, s: int, amount: float) -> float:
    """Add an amount [mol] of a substance to each body; return the total [mol]."""
    volume, brought = bodies.volume, 0.0
    for row in rows:
        before = held(bodies, row, s)
        after = hold(bodies, row, s, max(before + amount / volume[row], 0.0))
        brought += (after - before) * volume[row]
    return brought
