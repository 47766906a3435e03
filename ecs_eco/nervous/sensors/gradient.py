"""The sensor of smell gradients."""

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.nervous.sensors.sense import Sense, of_sensor
from ecs_eco.space.field import at as field_at
from ecs_eco.space.geometry import Extent, into
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.sight import Poses

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def smell_gradient(field: str, span: float, scale: float, number: int = 0) -> Sense:
    """Compare a field at two points `span` [m] apart along each axis of the body: (a − b)/(a + b + scale)."""

    def read(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        width, least = of_sensor(table, seekers, number, span=np.float32(span), scale=np.float32(scale))
        f, half = world.fields[field], width * np.float32(0.5)
        world.split(
            compare,
            seekers.n,
            f.value,
            f.inverse,
            seekers.poses,
            half,
            least,
            world.space.extent,
            out.T,
            column,
        )

    return Sense(read)


@njit
def compare(
    first: int,
    last: int,
    value: np.ndarray,
    inverse: np.ndarray,
    seekers: Poses,
    half: Number,
    scale: Number,
    space: Extent,
    out: np.ndarray,
    column: int,
) -> None:
    """Write the normalized differences forward, to the left and, in a volume, upward."""
    ox, oy, oz, _, cos, sin = seekers
    lengths, torus, volume = space.lengths, space.torus, space.volume
    for i in range(first, last):
        for axis in range(3 if volume else 2):
            side = of_row(half, i)
            dx, dy, dz = side * cos[i], side * sin[i], np.float32(0.0)
            if axis == 1:
                dx, dy = -side * sin[i], side * cos[i]
            if axis == 2:
                dx, dy, dz = np.float32(0.0), np.float32(0.0), side
            a = field_at(
                value,
                into(ox[i] + dx, lengths[0], torus),
                into(oy[i] + dy, lengths[1], torus),
                into(oz[i] + dz, lengths[2], False),
                inverse,
                torus,
            )
            b = field_at(
                value,
                into(ox[i] - dx, lengths[0], torus),
                into(oy[i] - dy, lengths[1], torus),
                into(oz[i] - dz, lengths[2], False),
                inverse,
                torus,
            )
            out[column + axis, i] = (a - b) / (a + b + of_row(scale, i))
