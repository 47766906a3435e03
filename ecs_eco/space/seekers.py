"""The living of a table that look for neighbors: their positions, and the nearest member of another table
to each."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.elementary import arrays
from ecs_eco.components import Body, Position, Shape
from ecs_eco.space.bodies import extents
from ecs_eco.space.nearest import nearest
from ecs_eco.space.pairs import radii

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Seekers:
    """The living of a table in canonical order, which does not depend on rows: `n` of them, their `rows`
    i64[n], neighbor `index` (uids and positions), `heading` [rad], its `cos` and `sin`, and `radius` [m],
    f32[n].

    Sensors receive one, and systems create one in `update`. Never hold one across ticks: rows change.
    """

    def __init__(self, world: SpatialWorld, table: Table) -> None:
        self.world, self.index = world, world.index(table)
        self.rows: np.ndarray = self.index.rows.copy()
        self.heading: np.ndarray = table[Position].heading.take(self.rows)  # twice as fast as [rows]
        self.cos: np.ndarray = arrays.cos(self.heading)
        self.sin: np.ndarray = arrays.sin(self.heading)
        self.n = int(self.rows.size)
        self.radius: np.ndarray = (
            table[Body].radius.take(self.rows) if Body in table else np.zeros(self.n, np.float32)
        )
        self.half: tuple[np.ndarray, ...] | None = None
        """Half of the length, width and height of each body, f32[n] [m]; None if all are spheres."""
        if Shape in table:
            *sides, rounding = (side[self.rows] for side in extents(table))
            self.half = tuple((side / 2 + rounding).astype(np.float32) for side in sides)

    def nearest(self, other: Table | str, radius: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the row of the nearest member of another table that is closer than `radius` [m] to each,
        i64[n], −1 if there is none; and its distance f32[n] [m], infinite if there is none.

        Distances are from center to center, the shorter way around a torus. `other` may be the same table: no
        organism is its own neighbor. Raises KeyError for an unknown table, ValueError for an invalid radius.
        """
        targets = self.world.index(self.world.table(other) if isinstance(other, str) else other)
        entry, distance2 = np.empty(self.n, np.int32), np.empty(self.n, np.float32)
        nearest(self.index, targets, float(radii(radius, 1)[0]), entry, distance2, self.world.split)
        rows, distance, found = np.full(self.n, -1), np.full(self.n, np.inf, np.float32), entry >= 0
        rows[found], distance[found] = targets.rows[entry[found]], np.sqrt(distance2[found])
        return rows, distance
