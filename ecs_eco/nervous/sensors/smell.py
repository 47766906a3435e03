"""The sensor that smells a scalar field at a point on the body."""

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import lone_njit, njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Senses
from ecs_eco.nervous.sensors.sense import Sense, nose, of_sensor, place_of
from ecs_eco.space.field import at as field_at
from ecs_eco.space.geometry import Extent, into
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.sight import Poses

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def smell(field: str, at: list[float], scale: float, number: int = 0) -> Sense:
    """Smell a field at a point on the body: c/(c + scale), the occupancy of receptors that are half bound at
    `scale`."""
    forward, left, up = (np.float32(v) for v in [*at, 0.0, 0.0, 0.0][:3])
    shared = np.float32(scale)

    def read(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        f, space, poses = world.fields[field], world.space, seekers.poses
        ahead, aside, high = forward, left, up
        if seekers.half is not None:
            poses = seekers.poses_at(*place_of(table, seekers, number, at, space))
            ahead = aside = high = np.float32(0)
        elif number in table.species.own_places:  # the kernel computes the position of each nose
            own = table[Senses]
            x, y = nose(seekers, own.forward[seekers.rows, number], own.left[seekers.rows, number], space)
            poses, ahead, aside = seekers.poses_at(x, y, poses.z), np.float32(0), np.float32(0)
        half = (
            of_sensor(table, seekers, number, half_saturation=shared)[0] if table.species.traits else shared
        )
        if space.volume:
            world.split(
                _sniff_volume,
                seekers.n,
                f.value,
                f.inverse,
                poses,
                seekers.radius,
                ahead,
                aside,
                high,
                half,
                space.extent,
                out.T,
                column,
                work=seekers.n // 5,
            )
        else:
            world.split(
                _sniff_plane,
                seekers.n,
                f.value[0],
                f.inverse,
                poses,
                seekers.radius,
                ahead,
                aside,
                half,
                space.torus,
                out.T,
                column,
                work=seekers.n // 10,
            )

    return Sense(read)


@lone_njit
def _sniff_plane(
    first: int,
    last: int,
    value: np.ndarray,
    inverse: np.ndarray,
    seekers: Poses,
    radius: np.ndarray,
    forward: np.float32,
    left: np.float32,
    scale: Number,
    torus: bool,
    out: np.ndarray,
    column: int,
) -> None:
    """Read the field f32[ny, nx] at the noses. Branch-free and with unsigned indices, so that it vectorizes."""
    ox, oy, _, _, cos, sin = seekers
    ny, nx = value.shape
    flat = value.reshape(-1)
    half, zero, one, fnx, fny = (
        np.float32(0.5),
        np.float32(0.0),
        np.float32(1.0),
        np.float32(nx),
        np.float32(ny),
    )
    last_x, last_y = fnx - one, fny - one
    for k in range(last - first):
        i = np.uint64(first + k)
        r = radius[i]
        gx = (ox[i] + r * (forward * cos[i] - left * sin[i])) * inverse[0] - half
        gy = (oy[i] + r * (forward * sin[i] + left * cos[i])) * inverse[1] - half
        bx, by = np.floor(gx), np.floor(gy)
        fx, fy = gx - bx, gy - by
        if torus:
            x0, y0 = bx + fnx if bx < zero else bx, by + fny if by < zero else by
            x0, y0 = x0 - fnx if x0 >= fnx else x0, y0 - fny if y0 >= fny else y0
            x0, y0 = x0 if x0 > zero else zero, y0 if y0 > zero else zero
            x0, y0 = x0 if x0 < last_x else last_x, y0 if y0 < last_y else last_y
            x1, y1 = x0 + one, y0 + one
            x1, y1 = x1 - fnx if x1 >= fnx else x1, y1 - fny if y1 >= fny else y1
        else:
            x0, y0, x1, y1 = bx if bx > zero else zero, by if by > zero else zero, bx + one, by + one
            x1, y1 = x1 if x1 > zero else zero, y1 if y1 > zero else zero
            x0, y0, x1, y1 = min(x0, last_x), min(y0, last_y), min(x1, last_x), min(y1, last_y)
        i0, i1, j0, j1 = (
            np.uint32(x0),
            np.uint32(x1),
            np.uint32(y0) * np.uint32(nx),
            np.uint32(y1) * np.uint32(nx),
        )
        south, north = (
            (one - fx) * flat[j0 + i0] + fx * flat[j0 + i1],
            (one - fx) * flat[j1 + i0] + fx * flat[j1 + i1],
        )
        c = (one - fy) * south + fy * north
        out[column, i] = c / (c + of_row(scale, i))


@njit
def _sniff_volume(
    first: int,
    last: int,
    value: np.ndarray,
    inverse: np.ndarray,
    seekers: Poses,
    radius: np.ndarray,
    forward: np.float32,
    left: np.float32,
    up: np.float32,
    scale: Number,
    space: Extent,
    out: np.ndarray,
    column: int,
) -> None:
    """Read the field f32[nz, ny, nx] at the noses."""
    (ox, oy, oz, _, cos, sin), lengths, torus = seekers, space.lengths, space.torus
    for i in range(first, last):
        r = radius[i]
        x = into(ox[i] + r * (forward * cos[i] - left * sin[i]), lengths[0], torus)
        y = into(oy[i] + r * (forward * sin[i] + left * cos[i]), lengths[1], torus)
        z = into(oz[i] + r * up, lengths[2], False)
        c = field_at(value, x, y, z, inverse, torus)
        out[column, i] = c / (c + of_row(scale, i))
