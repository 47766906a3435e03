"""The living members of a table that look for neighbors: their positions, and the nearest member of another
table to each."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.elementary import arrays
from ecs_eco.components import Body, Position, Shape
from ecs_eco.space.bodies import extents
from ecs_eco.space.nearest import nearest
from ecs_eco.space.pairs import radii
from ecs_eco.space.sight import Poses

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Seekers:
    """The living members of a table in an order that does not depend on rows.

    Sensors receive a `Seekers`, and systems create one in `update`. Never keep it across ticks.

    Parameters
    ----------
    world : World
    table : Table

    Attributes
    ----------
    n : int
    rows : array of int64, shape (n,)
    index : Index
        Neighbor index, with uids and positions.
    heading : array of float32, shape (n,)
        [rad], counterclockwise from the x axis; `cos` and `sin` are its cosine and sine.
    radius : array of float32, shape (n,)
        [m]
    poses : Poses
        Position, uid and heading, for kernels.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.space import Seekers
    >>> world = World.from_config("predator-prey", seed=1)
    >>> Seekers(world, world.table("deer")).n
    700
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
        mine = self.index
        self.poses = Poses(mine.x, mine.y, mine.z, mine.uid, self.cos, self.sin)
        self.half: tuple[np.ndarray, ...] | None = None
        """Half the length, width and height of each body, f32[n] [m]; None if all are spheres."""
        if Shape in table:
            *sides, rounding = (side[self.rows] for side in extents(table))
            self.half = tuple((side / 2 + rounding).astype(np.float32) for side in sides)

    def poses_at(self, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> Poses:
        """Return the seekers' poses at other positions, f32[n] [m]."""
        return Poses(x, y, z, *self.poses[3:])

    def nearest(self, other: Table | str, radius: float) -> tuple[np.ndarray, np.ndarray]:
        """Return, for each organism, the nearest member of another table.

        Parameters
        ----------
        other : Table or str
            It can be the same table; an organism is never its own neighbor.
        radius : float
            Search distance, from center to center [m].

        Returns
        -------
        rows : array of int64, shape (n,)
            Rows of the other table; −1 if no member is in reach.
        distances : array of float32, shape (n,)
            [m]; infinite if no member is in reach.

        Raises
        ------
        UnknownName
            If the table is unknown.
        ValueError
            If the radius is invalid.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.space import Seekers
        >>> world = World.from_config("predator-prey", seed=1)
        >>> rows, distances = Seekers(world, world.table("deer")).nearest("wolf", 5.0)
        >>> rows.shape, distances.dtype
        ((700,), dtype('float32'))
        """
        targets = self.world.index(self.world.table(other) if isinstance(other, str) else other)
        entry, distance2 = np.empty(self.n, np.int32), np.empty(self.n, np.float32)
        nearest(self.index, targets, float(radii(radius, 1)[0]), entry, distance2, self.world.split)
        rows, distance, found = np.full(self.n, -1), np.full(self.n, np.inf, np.float32), entry >= 0
        rows[found], distance[found] = targets.rows[entry[found]], np.sqrt(distance2[found])
        return rows, distance
