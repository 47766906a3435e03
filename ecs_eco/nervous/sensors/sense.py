"""The common base of sensors: the organisms that sense now, the position of a sensor on the body, and its
range."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.components import Senses
from ecs_eco.genomes.own_values import own_values
from ecs_eco.space.geometry import back_into
from ecs_eco.space.seekers import Seekers

if TYPE_CHECKING:
    from ecs_eco.compiled.per_row import Number
    from ecs_eco.engine.table import Table
    from ecs_eco.space.geometry import Space
    from ecs_eco.space.world import SpatialWorld


NOTHING_SENSED = np.zeros(0, np.uint64), np.zeros((0, 0), np.float32)
"""Empty uids u64[0] and readings f32[0, channels]."""


Reading = Callable[["SpatialWorld", "Table", Seekers, np.ndarray, int], None]
"""reading(world, table, seekers, observations f32[n, channels], first column):
writes its channels for every seeker."""


class Sense(NamedTuple):
    """A sensor of a nervous system."""

    read: Reading
    divisible: bool = True  # whether each process can read it for its own part of the organisms

    def __call__(
        self, world: SpatialWorld, table: Table, seekers: Seekers, out: np.ndarray, column: int
    ) -> None:
        """Write the channels of every seeker."""
        self.read(world, table, seekers, out, column)


def of_sensor(table: Table, seekers: Seekers, number: int, **shared: object) -> tuple[Any, ...]:
    """Return some numbers of a sensor: unchanged or, if a gene codes for any of them, one per seeker."""
    if not table.species.traits:
        return tuple(shared.values())
    name = table.species.sensors[number].name
    values = own_values(table, {f"sensors.{name}.{field}": value for field, value in shared.items()})
    return tuple(v[seekers.rows] if isinstance(v, np.ndarray) else v for v in values)


def own_range(table: Table, seekers: Seekers, number: int, radius: float) -> tuple[float, np.ndarray]:
    """Return the sensor's largest range, and each seeker's range f32[n] [m]; `radius` if ranges are not
    individual."""
    if number not in table.species.own_ranges or not seekers.n:
        all_equal = np.empty(seekers.n, np.float32)
        all_equal.fill(radius)
        return radius, all_equal
    own = table[Senses].radius[seekers.rows, number]
    return float(own.max()), own


def in_light(
    world: SpatialWorld,
    table: Table,
    seekers: Seekers,
    number: int,
    eye: tuple[np.ndarray, ...],
    own: np.ndarray,
    by_light: float,
    blind: float,
) -> np.ndarray:
    """Return how far each seeker sees, f32[n] [m]: blind + by_light × light at its eye, at most `own`."""
    light = world.surroundings("light", *eye)
    near, far = of_sensor(table, seekers, number, blind=np.float32(blind), sight=np.float32(by_light))
    out: np.ndarray = np.minimum(own, near + far * light)
    return out


def place_of(
    table: Table, seekers: Seekers, number: int, at: Sequence[Number], space: Space
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the position of a sensor on each body: x, y, z f32[n] [m].

    `at` is forward, to the left and, optionally, up, in radii of the body, unless organisms have individual
    values; for a capsule or box, the units are half its length, width and height.
    """
    x, y, z = seekers.index.x, seekers.index.y, seekers.index.z
    own = number in table.species.own_places
    if not (own or any(map(np.float32, at[:3]))):
        return x, y, z
    forward, left, up = (np.float32(v) for v in [*at, 0.0, 0.0, 0.0][:3])
    ahead, aside = (
        (table[Senses].forward[seekers.rows, number], table[Senses].left[seekers.rows, number])
        if own
        else (forward, left)
    )
    x, y = nose(seekers, ahead, aside, space)
    if space.volume:
        high = seekers.radius if seekers.half is None else seekers.half[2]
        z = back_into(z + high * up, space.lengths[2], space.wrap[2])
    return x, y, z


def nose(seekers: Seekers, forward: Number, left: Number, space: Space) -> tuple[np.ndarray, np.ndarray]:
    """Return x and y f32[n] of a point on each body, given in radii forward and to the left; for a capsule or
    box, the units are half its length and width."""
    radius: Any = seekers.radius
    if seekers.half is not None:
        forward, left, radius = forward * seekers.half[0], left * seekers.half[1], np.float32(1)
    x = seekers.index.x + radius * (forward * seekers.cos - left * seekers.sin)
    y = seekers.index.y + radius * (forward * seekers.sin + left * seekers.cos)
    return back_into(x, space.lengths[0], space.wrap[0]), back_into(y, space.lengths[1], space.wrap[1])
