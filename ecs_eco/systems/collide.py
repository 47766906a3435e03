"""Bodies push each other apart."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Body, Position, Shape, Velocity
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.space.barriers import barriers, hold_back
from ecs_eco.space.bodies import merged, rocks, solids
from ecs_eco.space.geometry import into
from ecs_eco.space.shapes import bounds, contact, shift_to
from ecs_eco.space.sight import gather, offset
from ecs_eco.space.solids import around
from ecs_eco.space.terrain import OPEN, closed_between, ground_at
from ecs_eco.space.world import SpatialWorld

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


class Collide(System):
    """Overlapping bodies push each other apart, each by half of the overlap; a body that cannot move pushes
    by all of it.

    All pushes are computed from the positions before any push: the outcome does not depend on the order. The
    edge of the space ends a push; no body is pushed through a capsule or box that cannot move, nor over rock,
    water or a fence. Pushed bodies do not turn.
    """

    needs = (Position, Velocity, Body)
    phase = "interact"
    divisible = True
    submodel = Submodel(
        "Collision",
        where=("body.solid",),
        rules={
            "": "Bodies with an overlap o move apart by o/2 each along the line through their centers; a "
            "body moves by o if the other cannot move."
        },
        changes=("Position",),
    )
    world: SpatialWorld

    def process(self, *_: object) -> None:
        """Push all solid bodies apart, once."""
        world = self.world
        solid = [t for t in world.tables.values() if t.species.body.solid and t.has((Position, Body))]
        pushes = []
        for table in solid:
            if not moves(table) or not table.n:
                continue
            index, largest = world.index(table), merged(world, [table.name]).largest
            push = np.zeros((index.n, 3), np.float32)
            for other in solid:
                share = np.float32(0.5 if moves(other) else 1.0)
                if Shape in table or Shape in other:
                    push_solids(world, table, other, share, push)
                    continue
                bodies = merged(world, [other.name])
                reach = world.space.reach(largest + bodies.largest)
                world.split(
                    push_apart,
                    index.n,
                    index.x,
                    index.y,
                    index.z,
                    index.uid,
                    index.rows,
                    table[Body].radius,
                    bodies.x,
                    bodies.y,
                    bodies.z,
                    bodies.radius,
                    bodies.uid,
                    bodies.start,
                    *world.space.shape,
                    world.space.inverse,
                    world.space.lengths,
                    world.space.torus,
                    reach,
                    share,
                    push,
                )
            pushes.append((table, index.rows.copy(), push))
        if not pushes:
            return
        ground, inverse = rocks(world)
        walls = barriers(world)
        for table, rows, push in pushes:
            p = table[Position]
            if walls is not None:
                hold_back(world, walls, p.x[rows], p.y[rows], p.z[rows], push)
            _displace(
                rows,
                push,
                world.space.lengths,
                world.space.torus,
                world.space.volume,
                ground,
                inverse,
                p.x,
                p.y,
                p.z,
            )
            table.version += 1


def moves(table: Table) -> bool:
    """Return whether bodies of a table give way: those that move, and objects that can be pushed."""
    return Velocity in table or table.species.pushed


def push_solids(world: SpatialWorld, table: Table, other: Table, share: np.float32, push: np.ndarray) -> None:
    """Add to push f32[n, 3] [m] the displacement of each body of a table out of the bodies of another, if
    some are not spheres; rows are those of the table's index."""
    mine, theirs, space = solids(world, [table.name]), solids(world, [other.name]), world.space
    world.split(
        push_shapes,
        len(push),
        mine.form,
        mine.uid,
        theirs.form,
        theirs.uid,
        *space.shape,
        space.inverse,
        space.lengths,
        space.torus,
        space.volume,
        *theirs.cells,
        share,
        push,
    )


@njit
def push_shapes(
    first,
    last,
    form,
    uid,
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
    share,
    push,
):
    """Do the same as `push_apart` for bodies of any shape: along the shortest way out of each other."""
    near, seen = np.empty(len(other), np.int64), np.zeros(len(other) + 1, np.int64)
    images = 2 if torus else 1
    for i in range(first, last):
        x, y, z = np.float64(form[i, 0]), np.float64(form[i, 1]), np.float64(form[i, 2])
        ex, ey, ez = bounds(form, i)
        for q in range(
            around(x, y, z, ex, ey, ez, nx, ny, nz, inverse, lengths, torus, start, entry, seen, near)
        ):
            e = near[q]
            if other_uid[e] == uid[i]:
                continue
            fx, fy, _ = bounds(other, e)
            dx, dy, dz = x - other[e, 0], y - other[e, 1], z - other[e, 2]
            tie = 1.0 if uid[i] > other_uid[e] else -1.0
            for image in range(images * images):
                ax = shift_to(dx, lengths[0], ex + fx, image % 2) if torus else dx
                ay = shift_to(dy, lengths[1], ey + fy, image // 2) if torus else dy
                if abs(ax) > ex + fx or abs(ay) > ey + fy:
                    continue
                gap, px, py, pz = contact(form, i, other, e, ax, ay, dz, volume, tie)
                if gap < 0:
                    push[i, 0] -= np.float32(share * gap * px)
                    push[i, 1] -= np.float32(share * gap * py)
                    push[i, 2] -= np.float32(share * gap * pz)


@njit
def push_apart(
    first,
    last,
    ox,
    oy,
    oz,
    ou,
    rows,
    radius,
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
    reach,
    share,
    push,
):
    """Add to push[i] the displacement out of every body that overlaps i; concentric ones part in a
    direction set by their uids."""
    near = np.empty(bx.size, np.int64)
    for i in range(first, last):
        r = radius[rows[i]]
        n = gather(ox[i], oy[i], oz[i], reach, bstart, bx, by, bz, nx, ny, nz, inverse, lengths, torus, near)
        for q in range(n):
            e = near[q]
            if bu[e] == ou[i]:
                continue
            dx, dy, dz = offset(bx[e], by[e], bz[e], ox[i], oy[i], oz[i], lengths, torus)
            s = r + br[e]
            d2 = dx * dx + dy * dy + dz * dz
            if d2 >= s * s:
                continue
            d = np.sqrt(d2)
            if d < np.float32(1e-6):
                dx, d = (np.float32(1.0) if ou[i] > bu[e] else np.float32(-1.0)), np.float32(1.0)
                depth = s
            else:
                depth = s - d
            push[i, 0] += share * depth * dx / d
            push[i, 1] += share * depth * dy / d
            push[i, 2] += share * depth * dz / d


@njit
def _displace(rows, push, lengths, torus, volume, ground, inverse, x, y, z):
    for i in range(rows.size):
        row = rows[i]
        nx, ny = into(x[row] + push[i, 0], lengths[0], torus), into(y[row] + push[i, 1], lengths[1], torus)
        if ground.size == 1 or (
            ground_at(ground, inverse, nx, ny) == OPEN
            and not closed_between(x[row], y[row], push[i, 0], push[i, 1], ground, inverse, lengths, torus)
        ):
            x[row] = nx
            y[row] = ny
        if volume:
            z[row] = into(z[row] + push[i, 2], lengths[2], False)
