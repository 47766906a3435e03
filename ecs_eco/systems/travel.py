"""Objects move."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Carrier, Position, Route
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.space.barriers import barriers, hold_back
from ecs_eco.space.bodies import ground_of
from ecs_eco.space.geometry import Extent, Places, into
from ecs_eco.space.sight import offset
from ecs_eco.space.terrain import Ground, along, is_open

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Travel(System):
    """Objects move on their own, either at a given velocity until rocks, lakes, fences or walls stop them, or
    along a closed path. Immovable solid capsules and boxes stop solid objects that move at a given velocity.
    Carried objects move with their carriers."""

    needs = (Position, Route)
    phase = "move"
    submodel = Submodel("Motion of objects", reads=("motion",), changes=("Position",))
    asked_for = staticmethod(lambda table: table.species.motion is not None)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Move one type of object for one tick."""
        motion, p, space = table.species.motion, table[Position], world.space.extent
        if motion is None or not table.n:
            return
        free = table.alive[: table.high]
        if Carrier in table:
            free = free & (table[Carrier].uid[: table.high] == 0)
        places = Places(p.x, p.y, p.z)
        if motion.path is None:
            step = np.zeros(3, np.float32)
            step[: len(motion.velocity)] = np.array(motion.velocity) * world.dt
            walls = barriers(world, table.name) if table.species.body.solid else None
            if walls is not None:
                rows = np.flatnonzero(free)
                ways = np.tile(step, (rows.size, 1))
                free = free.copy()
                free[rows] = hold_back(world, walls, p.x[rows], p.y[rows], p.z[rows], ways) == 1
            roll(free, step, space, ground_of(world), places, p.heading)
        else:
            path = np.array([[*place, 0.0][:3] for place in motion.path], np.float32)
            way = np.float32(motion.speed * world.dt)
            follow(free, path, way, space, places, p.heading, table[Route].leg)
        table.version += 1


@njit
def roll(
    free: np.ndarray, step: np.ndarray, space: Extent, ground: Ground, places: Places, heading: np.ndarray
) -> None:
    """Move all objects by a step f32[3] [m] unless rock, water or a fence is in the way."""
    x, y, z = places
    for row in range(free.size):
        if free[row]:
            nx, ny = along(x[row], y[row], step[0], step[1], space)
            if ground.kind.size == 1 or is_open(x[row], y[row], step[0], step[1], ground, space):
                x[row] = nx
                y[row] = ny
            if space.volume:
                z[row] = into(z[row] + step[2], space.lengths[2], False)
            if step[0] != 0 or step[1] != 0:
                heading[row] = facing(step[0], step[1])


@njit
def facing(dx, dy):
    """Return the heading of a step, 0 to 2π [rad]."""
    angle = np.arctan2(dy, dx)
    return angle if angle >= 0 else angle + np.float32(6.2831855)


@njit
def follow(
    free: np.ndarray,
    path: np.ndarray,
    way: np.float32,
    space: Extent,
    places: Places,
    heading: np.ndarray,
    leg: np.ndarray,
) -> None:
    """Move all objects a distance [m] along a path f32[k, 3] [m], first toward corner leg[row]."""
    (x, y, z), lengths, torus, volume = places, space.lengths, space.torus, space.volume
    k = len(path)
    for row in range(free.size):
        if not free[row]:
            continue
        left, at = way, leg[row] % k
        for _ in range(k + 1000):  # a short path may be circled many times, but a path of length 0 cannot
            dx, dy, dz = offset(x[row], y[row], z[row], path[at, 0], path[at, 1], path[at, 2], space)
            if not volume:
                dz = np.float32(0.0)
            d = np.sqrt(dx * dx + dy * dy + dz * dz)
            if dx != 0 or dy != 0:
                heading[row] = facing(dx, dy)
            part = np.float32(1.0) if d <= left else left / d
            x[row] = path[at, 0] if part == 1 else into(x[row] + part * dx, lengths[0], torus)
            y[row] = path[at, 1] if part == 1 else into(y[row] + part * dy, lengths[1], torus)
            if volume:
                z[row] = path[at, 2] if part == 1 else into(z[row] + part * dz, lengths[2], False)
            if d > left:
                break
            left -= d
            at = (at + 1) % k
        leg[row] = at
