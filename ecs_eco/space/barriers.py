"""Barriers: immovable solid capsules and boxes, which stop every solid body, however fast it moves."""

import math
from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Body, Position, Shape, Velocity
from ecs_eco.space.bodies import solids
from ecs_eco.space.geometry import Extent, Places, back_into
from ecs_eco.space.shapes import contact, image_of, ray
from ecs_eco.space.solids import Solids, around

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

SHORT = 1e-4  # share of a displacement that is left in front of a barrier
POINT = np.array([[0, 0, 0, 0, 0, 0, 0, 1, 0]], np.float32)  # the form of a point


def barriers(world: "SpatialWorld", but: str = "") -> Solids | None:
    """Return the immovable solid capsules and boxes in all tables except `but`; None if there are none."""
    names = [
        n
        for n, t in world.tables.items()
        if n != but
        and t.n
        and t.species.body.solid
        and t.has((Position, Body, Shape))
        and Velocity not in t
        and not t.species.pushed
    ]
    return solids(world, names) if names else None


def hold_back(
    world: "SpatialWorld", walls: Solids, x: np.ndarray, y: np.ndarray, z: np.ndarray, way: np.ndarray
) -> np.ndarray:
    """Clip displacements f32[n, 3] [m] from positions f32[n] at the edges of the space, and shorten any that
    lead into a barrier so that they end just before it. Return the shortening factors f32[n].

    A body inside a barrier can leave it but cannot go deeper. On a torus, a displacement may be longer than
    the torus, up to the sum of its sides.
    """
    space, share = world.space, np.ones(x.size, np.float32)
    for axis, at in enumerate((x, y, z)):
        if not space.wrap[axis]:
            furthest = np.nextafter(space.lengths[axis], np.float32(0))
            np.clip(way[:, axis], -at, furthest - at, out=way[:, axis])
    world.split(shorten, x.size, Places(x, y, z), walls, space.extent, POINT, way, share)
    return share


def stop(
    world: "SpatialWorld", table: "Table", walls: Solids, before: np.ndarray, way: np.ndarray
) -> np.ndarray:
    """Stop the living members of a table, displaced by f32[n, 3] [m] from positions f32[rows, 3] [m], in
    front of barriers; return the shortening factors f32[n]."""
    p, space, rows = table[Position], world.space, table.rows()
    x, y, z = before[rows].T.copy()
    share = hold_back(world, walls, x, y, z, way)
    held = share < 1
    for axis, name in enumerate("xyz"[: len(space.size)]):
        place = back_into((before[rows, axis] + way[:, axis])[held], space.lengths[axis], space.wrap[axis])
        getattr(p, name)[rows[held]] = place
    return share


@njit
def shorten(
    first: int,
    last: int,
    places: Places,
    walls: Solids,
    space: Extent,
    point: np.ndarray,
    way: np.ndarray,
    share: np.ndarray,
) -> None:
    """Run `hold_back` for displacements first … last − 1, in parts of at most half a torus, and check the
    nearest images for each part."""
    (x, y, z), lengths, torus, n = places, space.lengths, space.torus, len(walls.form)
    near, seen = np.empty(n, np.int64), np.zeros(n + 1, np.int64)
    half = np.float64(min(lengths[0], lengths[1])) / 2 if torus else np.inf
    most = np.float64(lengths[0] + lengths[1]) if torus else np.inf
    for i in range(first, last):
        wx, wy, wz = np.float64(way[i, 0]), np.float64(way[i, 1]), np.float64(way[i, 2])
        if wx == 0 and wy == 0 and wz == 0:
            continue
        longest = max(abs(wx), abs(wy))
        whole = most / longest if longest > most else 1.0  # the part of the displacement that is checked
        parts = max(math.ceil(whole * longest / half), 1)
        wx, wy, wz = wx * whole / parts, wy * whole / parts, wz * whole / parts
        px, py, pz, free, part = np.float64(x[i]), np.float64(y[i]), np.float64(z[i]), 1.0, 0
        while free == 1 and part < parts:
            free = _free_part(px, py, pz, wx, wy, wz, walls, space, point, near, seen)
            px, py, pz, part = px + wx, py + wy, pz + wz, part + 1
            if torus:
                px -= lengths[0] * math.floor(px / lengths[0])
                py -= lengths[1] * math.floor(py / lengths[1])
        if free < 1 or whole < 1:
            share[i] = np.float32(max((part - 1 + free) / parts - SHORT, 0.0) * whole)
            for k in range(3):
                way[i, k] *= share[i]


@njit
def _free_part(px, py, pz, wx, wy, wz, walls, space, point, near, seen):
    """Return the share of a displacement (at most half a torus) at which a barrier begins; 1 if there is none."""
    images, free, form = 2 if space.torus else 1, 1.0, walls.form
    x, y, z = px + wx / 2, py + wy / 2, pz + wz / 2
    for q in range(around(x, y, z, abs(wx) / 2, abs(wy) / 2, abs(wz) / 2, walls, space, seen, near)):
        e = near[q]
        dx, dy, dz = px - form[e, 0], py - form[e, 1], pz - form[e, 2]
        for image in range(images * images):
            ax, ay = image_of(dx, dy, space, image)
            t = ray(form, e, ax, ay, dz, wx, wy, wz)
            if t >= free:
                continue
            if t == 0:
                _, ox, oy, oz = contact(point, 0, form, e, ax, ay, dz, space.volume, 1.0)
                if ox * wx + oy * wy + oz * wz >= 0:  # moving out of the barrier
                    continue
            free = t
    return free
