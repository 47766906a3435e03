"""The sensor that feels bodies and walls that touch the own body."""

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Body, Position
from ecs_eco.engine.jit import njit
from ecs_eco.nervous.sensors.sense import Seekers, Sense
from ecs_eco.space import sight
from ecs_eco.space.bodies import merged

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def touch(targets: list[str] | None, wall: bool, at: list[float], reach: float = 0.0) -> Sense:
    """Feel whether a body of a kind, or a wall, touches the own body within a sector of directions."""

    def sense(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        out[:, column] = 0
        mine, space = seekers.index, world.space
        names = ([n for n, t in world.tables.items() if Body in t and Position in t]
                 if targets is None else targets)
        if names:
            bodies = merged(world, names)
            widest = float(seekers.radius.max(initial=0.0)) + bodies.largest + reach
            world.split(_touch, seekers.n, mine.x, mine.y, mine.z, mine.uid, seekers.radius, seekers.heading,
                        bodies.x, bodies.y, bodies.z, bodies.radius, bodies.uid, bodies.start, *space.shape,
                        space.inverse, space.lengths, space.torus, space.reach(widest), np.float32(reach),
                        np.float32(at[0]), np.float32(at[1]), out, column)
        if wall and (space.volume or not space.torus):
            _touch_walls(mine.x, mine.y, mine.z, seekers.radius, seekers.heading, space.lengths, space.torus,
                         space.volume, np.float32(at[0]), np.float32(at[1]), out, column)

    return sense


@njit
def within(angle, begin, end):
    """Return whether an angle lies in the sector from `begin` counter-clockwise
    to `end` (a whole circle where they span it)."""
    turn = np.float32(6.2831855)
    width = end - begin
    if width >= turn - np.float32(1e-5):
        return True
    a = angle - begin
    a -= turn * np.float32(np.floor(a / turn))
    if width < 0:
        width += turn
    return a <= width


@njit
def _touch(first, last, ox, oy, oz, ou, radius, heading, bx, by, bz, br, bu, bstart, nx, ny, nz, inverse,
           lengths, torus, reach_cells, reach, begin, end, out, column):
    near = np.empty(bx.size, np.int64)
    for i in range(first, last):
        r = radius[i]
        n = sight.gather(ox[i], oy[i], oz[i], reach_cells, bstart, bx, by, bz, nx, ny, nz, inverse, lengths,
                         torus, near)
        for q in range(n):
            e = near[q]
            if bu[e] == ou[i]:
                continue
            dx, dy, dz = sight.offset(ox[i], oy[i], oz[i], bx[e], by[e], bz[e], lengths, torus)
            s = r + br[e] + reach
            if dx * dx + dy * dy + dz * dz <= s * s and within(np.float32(np.arctan2(dy, dx)) - heading[i],
                                                               begin, end):
                out[i, column] = 1
                break


@njit
def _touch_walls(ox, oy, oz, radius, heading, lengths, torus, volume, begin, end, out, column):
    half = np.float32(1.5707964)
    for i in range(radius.size):
        r, h = radius[i], heading[i]
        if volume and (oz[i] <= r or oz[i] >= lengths[2] - r):
            out[i, column] = 1
        if torus:
            continue
        if ((ox[i] >= lengths[0] - r and within(-h, begin, end))
                or (ox[i] <= r and within(half + half - h, begin, end))
                or (oy[i] >= lengths[1] - r and within(half - h, begin, end))
                or (oy[i] <= r and within(-half - h, begin, end))):
            out[i, column] = 1
