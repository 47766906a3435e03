"""The sensor of bodies and walls that touch the own body."""

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Body, Position, Shape
from ecs_eco.nervous.sensors.sense import Sense
from ecs_eco.space import sight
from ecs_eco.space.bodies import merged, solids
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.shapes import bounds, touching
from ecs_eco.space.solids import around

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def touch(targets: list[str] | None, wall: bool, at: list[float], reach: float = 0.0) -> Sense:
    """Feel whether a body of a kind, or a wall, touches the own body within a sector of directions."""

    def sense(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
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
                me.form,
                me.uid,
                seekers.heading,
                others.form,
                others.uid,
                *space.shape,
                space.inverse,
                space.lengths,
                space.torus,
                space.volume,
                *others.cells,
                np.float32(reach),
                np.float32(at[0]),
                np.float32(at[1]),
                out.T,
                column,
            )
        if names := [n for n in names if n not in shaped]:
            bodies = merged(world, names)
            widest = float(seekers.radius.max(initial=0.0)) + bodies.largest + reach
            world.split(
                _touch,
                seekers.n,
                mine.x,
                mine.y,
                mine.z,
                mine.uid,
                seekers.radius,
                seekers.heading,
                bodies.x,
                bodies.y,
                bodies.z,
                bodies.radius,
                bodies.uid,
                bodies.start,
                *space.shape,
                space.inverse,
                space.lengths,
                space.torus,
                space.reach(widest),
                np.float32(reach),
                np.float32(at[0]),
                np.float32(at[1]),
                out.T,
                column,
            )
        if wall and (space.volume or not space.torus):
            _touch_walls(
                mine.x,
                mine.y,
                mine.z,
                *sides(world, table, seekers),
                seekers.heading,
                space.lengths,
                space.torus,
                space.volume,
                np.float32(at[0]),
                np.float32(at[1]),
                out.T,
                column,
            )

    return sense


def sides(world: "SpatialWorld", table: "Table", seekers: Seekers) -> tuple[np.ndarray, ...]:
    """Return how far each body extends from its center along x, y and z: f32[n] [m]."""
    if Shape not in table:
        return seekers.radius, seekers.radius, seekers.radius
    out = np.empty((3, seekers.n), np.float32)
    _sides(solids(world, [table.name]).form, out)
    return tuple(out)


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
    first,
    last,
    ox,
    oy,
    oz,
    ou,
    radius,
    heading,
    bx,
    by,
    bz,
    br,
    bu,
    bstart,
    nx,
    ny,
    nz,
    inverse,
    lengths,
    torus,
    reach_cells,
    reach,
    begin,
    end,
    out,
    column,
):
    near = np.empty(bx.size, np.int64)
    for i in range(first, last):
        r = radius[i]
        n = sight.gather(
            ox[i], oy[i], oz[i], reach_cells, bstart, bx, by, bz, nx, ny, nz, inverse, lengths, torus, near
        )
        for q in range(n):
            e = near[q]
            if bu[e] == ou[i]:
                continue
            dx, dy, dz = sight.offset(ox[i], oy[i], oz[i], bx[e], by[e], bz[e], lengths, torus)
            s = r + br[e] + reach
            if dx * dx + dy * dy + dz * dz <= s * s and within(
                np.float32(np.arctan2(dy, dx)) - heading[i], begin, end
            ):
                out[column, i] = 1
                break


@njit
def _touch_solids(
    first,
    last,
    form,
    uid,
    heading,
    other,
    other_uid,
    nx,
    ny,
    nz,
    inverse,
    lengths,
    torus,
    volume,
    start,
    entry,
    reach,
    begin,
    end,
    out,
    column,
):
    """Do the same as `_touch` for bodies of any shape: the direction is that of the nearest points."""
    near, seen = np.empty(len(other), np.int64), np.zeros(len(other) + 1, np.int64)
    for i in range(first, last):
        x, y, z = np.float64(form[i, 0]), np.float64(form[i, 1]), np.float64(form[i, 2])
        ex, ey, ez = bounds(form, i)
        n = around(
            x,
            y,
            z,
            ex + reach,
            ey + reach,
            ez + reach,
            nx,
            ny,
            nz,
            inverse,
            lengths,
            torus,
            start,
            entry,
            seen,
            near,
        )
        for q in range(n):
            e = near[q]
            if other_uid[e] == uid[i]:
                continue
            gap, wx, wy, _ = touching(
                form, i, other, e, x - other[e, 0], y - other[e, 1], z - other[e, 2], lengths, torus, volume
            )
            if gap <= reach and within(np.float32(np.arctan2(wy, wx)) - heading[i], begin, end):
                out[column, i] = 1
                break


@njit
def _touch_walls(ox, oy, oz, ex, ey, ez, heading, lengths, torus, volume, begin, end, out, column):
    half = np.float32(1.5707964)
    for i in range(heading.size):
        h = heading[i]
        if volume and (oz[i] <= ez[i] or oz[i] >= lengths[2] - ez[i]):
            out[column, i] = 1
        if torus:
            continue
        if (
            (ox[i] >= lengths[0] - ex[i] and within(-h, begin, end))
            or (ox[i] <= ex[i] and within(half + half - h, begin, end))
            or (oy[i] >= lengths[1] - ey[i] and within(half - h, begin, end))
            or (oy[i] <= ey[i] and within(-half - h, begin, end))
        ):
            out[column, i] = 1
