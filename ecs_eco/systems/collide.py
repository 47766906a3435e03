"""Bodies push each other apart."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Body, Position, Shape, Velocity
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.space.barriers import barriers, hold_back
from ecs_eco.space.bodies import ground_of, merged, solids
from ecs_eco.space.geometry import Extent, Places, into
from ecs_eco.space.index import Entries
from ecs_eco.space.shapes import bounds, contact, shift_to
from ecs_eco.space.sight import gather, offset
from ecs_eco.space.solids import Solids, around
from ecs_eco.space.spheres import Spheres
from ecs_eco.space.terrain import OPEN, Ground, along, closed_between, ground_at
from ecs_eco.space.world import SpatialWorld

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


class Collide(System):
    """Overlapping bodies push each other apart, each moving by half the overlap; if one of them cannot move,
    the other moves by the whole overlap.

    All pushes are computed from the positions before any push, so the outcome does not depend on their order.
    Pushes stop at the edge of the space; no body is pushed through an immovable capsule or box, or across
    rock, water or a fence. Pushed bodies do not turn.
    """

    needs = (Position, Velocity, Body)
    phase = "interact"
    divisible = True
    submodel = Submodel(
        "Collision",
        where=("body.solid",),
        rules={
            "": "Two bodies with overlap o each move o/2 apart along the line through their centers; if "
            "one cannot move, the other moves by o."
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
                reach = world.space.reach(float(largest) + float(bodies.largest))
                world.split(
                    push_apart,
                    index.n,
                    index.entries,
                    table[Body].radius,
                    bodies,
                    world.space.extent,
                    reach,
                    share,
                    push,
                )
            pushes.append((table, index.rows.copy(), push))
        if not pushes:
            return
        ground, space = ground_of(world), world.space.extent
        walls = barriers(world)
        for table, rows, push in pushes:
            p = table[Position]
            if walls is not None:
                hold_back(world, walls, p.x[rows], p.y[rows], p.z[rows], push)
            _displace(rows, push, space, ground, Places(p.x, p.y, p.z))
            table.version += 1


def moves(table: Table) -> bool:
    """Return whether a table's bodies give way: either they move or they are objects that can be pushed."""
    return Velocity in table or table.species.pushed


def push_solids(world: SpatialWorld, table: Table, other: Table, share: np.float32, push: np.ndarray) -> None:
    """Add each body's displacement out of another table's bodies, some of which are not spheres, to push
    f32[n, 3] [m]; rows follow the table's index."""
    mine, theirs = solids(world, [table.name]), solids(world, [other.name])
    world.split(push_shapes, len(push), mine, theirs, world.space.extent, share, push)


@njit
def push_shapes(
    first: int, last: int, mine: Solids, theirs: Solids, space: Extent, share: np.float32, push: np.ndarray
) -> None:
    """Like `push_apart`, but for bodies of any shape, each pushed along the shortest path out of the other."""
    form, uid, other, other_uid = mine.form, mine.uid, theirs.form, theirs.uid
    lengths, torus, volume = space.lengths, space.torus, space.volume
    near, seen = np.empty(len(other), np.int64), np.zeros(len(other) + 1, np.int64)
    images = 2 if torus else 1
    for i in range(first, last):
        x, y, z = np.float64(form[i, 0]), np.float64(form[i, 1]), np.float64(form[i, 2])
        ex, ey, ez = bounds(form, i)
        for q in range(around(x, y, z, ex, ey, ez, theirs, space, seen, near)):
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
    first: int,
    last: int,
    mine: Entries,
    radius: np.ndarray,
    bodies: Spheres,
    space: Extent,
    reach: int,
    share: np.float32,
    push: np.ndarray,
) -> None:
    """Add to push[i] the displacement of body i out of every body that overlaps it; concentric bodies
    separate in a direction set by their uids."""
    rows, ox, oy, oz, ou, _ = mine
    bx, by, bz, br, bu, _, _, _ = bodies
    near = np.empty(bx.size, np.int64)
    for i in range(first, last):
        r = radius[rows[i]]
        n = gather(ox[i], oy[i], oz[i], reach, bodies, space, near)
        for q in range(n):
            e = near[q]
            if bu[e] == ou[i]:
                continue
            dx, dy, dz = offset(bx[e], by[e], bz[e], ox[i], oy[i], oz[i], space)
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
def _displace(rows: np.ndarray, push: np.ndarray, space: Extent, ground: Ground, places: Places) -> None:
    x, y, z = places
    for i in range(rows.size):
        row = rows[i]
        nx, ny = along(x[row], y[row], push[i, 0], push[i, 1], space)
        if ground.kind.size == 1 or (
            ground_at(ground, nx, ny) == OPEN
            and not closed_between(x[row], y[row], push[i, 0], push[i, 1], ground, space)
        ):
            x[row] = nx
            y[row] = ny
        if space.volume:
            z[row] = into(z[row] + push[i, 2], space.lengths[2], False)
