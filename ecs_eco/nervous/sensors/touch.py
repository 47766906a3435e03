"""The sensor for bodies and walls that touch the organism's body."""

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Body, Position, Shape
from ecs_eco.nervous.sensors.sense import Sense
from ecs_eco.space.bodies import merged, solids
from ecs_eco.space.geometry import Extent, Places
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.shapes import bounds, touching
from ecs_eco.space.sight import Poses, gather, offset
from ecs_eco.space.solids import Solids, around
from ecs_eco.space.spheres import Spheres

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def touch(targets: list[str] | None, wall: bool, at: list[float], reach: float = 0.0) -> Sense:
    """Feel whether a body of a kind, or a wall, touches the organism's body within a sector of directions."""

    def read(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        out[:, column] = 0
        mine, space = seekers.index, world.space
        names = (
            [n for n, t in world.tables.items() if Body in t and Position in t]
            if targets is None
            else targets
        )
        shaped = names if Shape in table else [n for n in names if Shape in world.tables[n]]
        if shaped:
            me, others = solids(world, [table.name]), solids(world, shaped)
            world.split(
                _touch_solids,
                seekers.n,
                me,
                seekers.heading,
                others,
                space.extent,
                np.float32(reach),
                np.float32(at[0]),
                np.float32(at[1]),
                out.T,
                column,
            )
        if names := [n for n in names if n not in shaped]:
            bodies = merged(world, names)
            widest = float(seekers.radius.max(initial=0.0)) + float(bodies.largest) + reach
            world.split(
                _touch,
                seekers.n,
                seekers.poses,
                seekers.radius,
                seekers.heading,
                bodies,
                space.extent,
                space.reach(widest),
                np.float32(reach),
                np.float32(at[0]),
                np.float32(at[1]),
                out.T,
                column,
            )
        if wall and (space.volume or not space.torus):
            _touch_walls(
                Places(mine.x, mine.y, mine.z),
                sides(world, table, seekers),
                seekers.heading,
                space.extent,
                np.float32(at[0]),
                np.float32(at[1]),
                out.T,
                column,
            )

    return Sense(read)


def sides(world: "SpatialWorld", table: "Table", seekers: Seekers) -> Places:
    """Return how far each body extends from its center along x, y and z: f32[n] [m]."""
    if Shape not in table:
        return Places(seekers.radius, seekers.radius, seekers.radius)
    out = np.empty((3, seekers.n), np.float32)
    _sides(solids(world, [table.name]).form, out)
    return Places(*out)


@njit
def _sides(form, out):
    for i in range(len(form)):
        out[0, i], out[1, i], out[2, i] = bounds(form, i)


@njit
def within(angle, begin, end):
    """Return whether an angle lies in the sector from `begin` counterclockwise to `end` (a whole circle if
    they span it)."""
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
def _touch(
    first: int,
    last: int,
    seekers: Poses,
    radius: np.ndarray,
    heading: np.ndarray,
    bodies: Spheres,
    space: Extent,
    reach_cells: int,
    reach: np.float32,
    begin: np.float32,
    end: np.float32,
    out: np.ndarray,
    column: int,
) -> None:
    ox, oy, oz, ou, _, _ = seekers
    bx, by, bz, br, bu, _, _, _ = bodies
    near = np.empty(bx.size, np.int64)
    for i in range(first, last):
        r = radius[i]
        n = gather(ox[i], oy[i], oz[i], reach_cells, bodies, space, near)
        for q in range(n):
            e = near[q]
            if bu[e] == ou[i]:
                continue
            dx, dy, dz = offset(ox[i], oy[i], oz[i], bx[e], by[e], bz[e], space)
            s = r + br[e] + reach
            if dx * dx + dy * dy + dz * dz <= s * s and within(
                np.float32(np.arctan2(dy, dx)) - heading[i], begin, end
            ):
                out[column, i] = 1
                break


@njit
def _touch_solids(
    first: int,
    last: int,
    mine: Solids,
    heading: np.ndarray,
    others: Solids,
    space: Extent,
    reach: np.float32,
    begin: np.float32,
    end: np.float32,
    out: np.ndarray,
    column: int,
) -> None:
    """Like `_touch`, but for bodies of any shape; the direction points from the body's center to its point
    nearest to the other body."""
    form, uid, other, other_uid = mine.form, mine.uid, others.form, others.uid
    near, seen = np.empty(len(other), np.int64), np.zeros(len(other) + 1, np.int64)
    for i in range(first, last):
        x, y, z = np.float64(form[i, 0]), np.float64(form[i, 1]), np.float64(form[i, 2])
        ex, ey, ez = bounds(form, i)
        n = around(x, y, z, ex + reach, ey + reach, ez + reach, others, space, seen, near)
        for q in range(n):
            e = near[q]
            if other_uid[e] == uid[i]:
                continue
            dx, dy, dz = x - other[e, 0], y - other[e, 1], z - other[e, 2]
            gap, wx, wy, _ = touching(form, i, other, e, dx, dy, dz, space)
            if gap <= reach and within(np.float32(np.arctan2(wy, wx)) - heading[i], begin, end):
                out[column, i] = 1
                break


@njit
def _touch_walls(
    places: Places,
    sides: Places,
    heading: np.ndarray,
    space: Extent,
    begin: np.float32,
    end: np.float32,
    out: np.ndarray,
    column: int,
) -> None:
    (ox, oy, oz), (ex, ey, ez), lengths = places, sides, space.lengths
    half = np.float32(1.5707964)
    for i in range(heading.size):
        h = heading[i]
        if space.volume and (oz[i] <= ez[i] or oz[i] >= lengths[2] - ez[i]):
            out[column, i] = 1
        if space.torus:
            continue
        if (
            (ox[i] >= lengths[0] - ex[i] and within(-h, begin, end))
            or (ox[i] <= ex[i] and within(half + half - h, begin, end))
            or (oy[i] >= lengths[1] - ey[i] and within(half - h, begin, end))
            or (oy[i] <= ey[i] and within(-half - h, begin, end))
        ):
            out[column, i] = 1
