"""Obstacles: ground that blocks movement and sight, and the bodies of several tables in one index."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.elementary import arrays
from ecs_eco.components import Body, Position, Shape
from ecs_eco.space.solids import Solids, listed_solids
from ecs_eco.space.spheres import Spheres, merged_spheres
from ecs_eco.space.terrain import OPEN_GROUND, ROCK, Ground

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def ground_of(world: "SpatialWorld") -> Ground:
    """Return the ground for kernels."""
    return OPEN_GROUND if world.terrain is None else world.terrain.maps


def opaque_ground(world: "SpatialWorld") -> Ground:
    """Return the ground for sight: a map of one cell if there is no rock, and a height map of one cell if
    hills do not block sight."""
    terrain = world.terrain
    if terrain is None:
        return OPEN_GROUND
    return Ground(
        terrain.ground if (terrain.ground == ROCK).any() else OPEN_GROUND.kind,
        terrain.height if terrain.hides else OPEN_GROUND.height,
        terrain.inverse,
    )


def tops(table: "Table", rows: np.ndarray) -> np.ndarray:
    """Return the heights f32[n] [m] of the bodies in these rows; their eyes are at the top."""
    if Shape not in table:
        return 2 * table[Body].radius[rows]
    _, _, height, rounding = extents(table)
    return (height + 2 * rounding)[rows].astype(np.float32)


def opaque_kinds(world: "SpatialWorld") -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of the tables whose bodies block sight: spheres first, then other shapes."""
    spheres: tuple[str, ...] = ()
    others: tuple[str, ...] = ()
    for name, table in world.tables.items():
        if table.species.body.opaque and Body in table:
            if Shape in table:
                others = *others, name
            else:
                spheres = *spheres, name
    return spheres, others


def merged(world: "SpatialWorld", names: Sequence[str]) -> Spheres:
    """Return the bodies of several tables in one index, rebuilt after any of them has changed."""

    def build() -> Spheres:
        return merged_spheres(
            world.space,
            [(world.index(table), table[Body].radius) for table in map(world.tables.__getitem__, names)],
        )

    return world._merged(tuple(names), build)


def solids(world: "SpatialWorld", names: Sequence[str]) -> Solids:
    """Return the bodies of several tables, of any shape, in one index of all cells that they touch;
    rebuilt after any of them has changed."""

    def build() -> Solids:
        tables = [world.tables[name] for name in names]
        rows = [world.index(table).rows.copy() for table in tables]
        return listed_solids(
            world.space, [(form_of(table, r), r, table.uid[r]) for table, r in zip(tables, rows, strict=True)]
        )

    return world._merged(tuple(names), build, "solids")


def form_of(table: "Table", rows: np.ndarray) -> np.ndarray:
    """Return the forms f32[n, 9] of the bodies in these rows, as defined in `ecs_eco.space.shapes`."""
    p, radius, form = table[Position], table[Body].radius[rows], np.zeros((rows.size, 9), np.float32)
    for i, column in enumerate((p.x, p.y, p.z)):
        form[:, i] = column[rows]
    form[:, 6], form[:, 7], form[:, 8] = radius, arrays.cos(p.heading[rows]), arrays.sin(p.heading[rows])
    if Shape in table:
        s = table[Shape]
        for i, column in enumerate((s.half_length, s.half_width, s.half_height, s.rounding)):
            form[:, 3 + i] = column[rows] * radius
    return form


def bound(table: "Table") -> float:
    """Return the radius [m] of the smallest sphere that can enclose any body of a table."""
    form = np.abs(form_of(table, table.rows()))
    return float((np.sqrt((form[:, 3:6] ** 2).sum(axis=1)) + form[:, 6]).max(initial=0.0))


def extents(table: "Table") -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the length, width and height of the box within each body of a table with Shape, and the radius
    of its rounding: f64[capacity] [m]."""
    s, radius = table[Shape], table[Body].radius.astype(np.float64)
    length, width, height = (2 * half * radius for half in (s.half_length, s.half_width, s.half_height))
    return length, width, height, s.rounding * radius
