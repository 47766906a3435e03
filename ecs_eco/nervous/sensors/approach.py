"""The sensor for the flow that an approaching body pushes ahead of itself."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Position, Velocity
from ecs_eco.nervous.sensors.sense import Sense, of_sensor, own_range
from ecs_eco.space.geometry import Extent
from ecs_eco.space.index import Entries
from ecs_eco.space.nearest import nearest
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.sight import Poses, offset

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def feel_approach(target: str, radius: float, scale: float, number: int = 0) -> Sense:
    """Feel the nearest member of a species within `radius` [m] while it approaches: its direction in the
    body's frame, and its speed/scale.

    Only the other body's motion relative to the water is felt, because a still body pushes no flow ahead of
    itself (Kiørboe & Visser 1999).
    """

    def read(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        other, mine = world.tables[target], seekers.index
        targets, space = world.index(other), world.space
        entries, distance2 = np.empty(seekers.n, np.int32), np.empty(seekers.n, np.float32)
        widest, own = own_range(table, seekers, number, radius)
        nearest(mine, targets, widest, entries, distance2, world.split)
        if number in table.species.own_ranges:
            entries[distance2 > own * own] = -1
        speed_felt = of_sensor(table, seekers, number, scale=np.float32(scale))[0]
        if Velocity not in other:
            entries[:] = -1
        heading = other[Position].heading
        speed, climb = (
            (other[Velocity].speed, other[Velocity].climb) if Velocity in other else (heading, heading)
        )
        world.split(
            close_in,
            seekers.n,
            seekers.poses,
            targets.entries,
            Motion(heading, speed, climb),
            entries,
            speed_felt,
            space.extent,
            out.T,
            column,
        )

    return Sense(read)


class Motion(NamedTuple):
    """Motion of bodies, for kernels: f32[rows]."""

    heading: np.ndarray  # [rad]
    speed: np.ndarray  # [m/s]
    climb: np.ndarray  # [m/s]


@njit
def close_in(
    first: int,
    last: int,
    seekers: Poses,
    targets: Entries,
    motion: Motion,
    entries: np.ndarray,
    scale: Number,
    space: Extent,
    out: np.ndarray,
    column: int,
) -> None:
    """Write the direction to the target that was found, and the speed at which the target's own motion brings
    it nearer."""
    ox, oy, oz, _, cos, sin = seekers
    rows, tx, ty, tz, _, _ = targets
    (heading, speed, climb), volume = motion, space.volume
    n = 4 if volume else 3
    for i in range(first, last):
        for c in range(n):
            out[column + c, i] = 0
        j = entries[i]
        if j < 0:
            continue
        dx, dy, dz = offset(ox[i], oy[i], oz[i], tx[j], ty[j], tz[j], space)
        inverse = np.float32(1.0) / max(np.sqrt(dx * dx + dy * dy + dz * dz), np.float32(1e-6))
        row = rows[j]
        closing = (
            -(speed[row] * (np.cos(heading[row]) * dx + np.sin(heading[row]) * dy) + climb[row] * dz)
            * inverse
        )
        if closing > 0:
            out[column, i] = (dx * cos[i] + dy * sin[i]) * inverse
            out[column + 1, i] = (dy * cos[i] - dx * sin[i]) * inverse
            if volume:
                out[column + 2, i] = dz * inverse
            out[column + n - 1, i] = closing / of_row(scale, i)
