"""Capsules and boxes that nobody passes through, however fast: what is solid, no sphere, and cannot move."""

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Body, Position, Shape, Velocity
from ecs_eco.engine.jit import njit
from ecs_eco.space.bodies import solids
from ecs_eco.space.shapes import contact, ray, shift_to
from ecs_eco.space.solids import Solids, around

if TYPE_CHECKING:
    from ecs_eco.space.world import SpatialWorld

SHORT = 1e-4  # share of a way by which it ends before a barrier
POINT = np.array([[0, 0, 0, 0, 0, 0, 0, 1, 0]], np.float32)  # the form of a body without extent


def barriers(world: "SpatialWorld") -> Solids | None:
    """Return the solid capsules and boxes that cannot move; None where there is none."""
    names = [n for n, t in world.tables.items()
             if t.n and t.species.solid and t.has((Position, Body, Shape))
             and Velocity not in t and not t.species.pushed]
    return solids(world, names) if names else None


def hold_back(world: "SpatialWorld", walls: Solids, x: np.ndarray, y: np.ndarray, z: np.ndarray,
              way: np.ndarray) -> np.ndarray:
    """Shorten ways f32[n, 3] [m] from places f32[n] that lead into a barrier, so that they end before it;
    return by what factor, f32[n].

    Who is within a barrier may leave it, and go no deeper.
    """
    space, share = world.space, np.ones(x.size, np.float32)
    world.split(shorten, x.size, x, y, z, walls.form, *space.shape, space.inverse, space.lengths, space.torus,
                space.volume, *walls.cells, POINT, way, share)
    return share


@njit
def shorten(first, last, x, y, z, form, nx, ny, nz, inverse, lengths, torus, volume, start, entry, point, way,
            share):
    """`hold_back` for the ways first … last − 1."""
    near, seen = np.empty(len(form), np.int64), np.zeros(len(form) + 1, np.int64)
    images = 2 if torus else 1
    for i in range(first, last):
        wx, wy, wz = np.float64(way[i, 0]), np.float64(way[i, 1]), np.float64(way[i, 2])
        if wx == 0 and wy == 0 and wz == 0:
            continue
        px, py, pz = np.float64(x[i]), np.float64(y[i]), np.float64(z[i])
        free = 1.0
        for q in range(around(px + wx / 2, py + wy / 2, pz + wz / 2, abs(wx) / 2, abs(wy) / 2, abs(wz) / 2,
                              nx, ny, nz, inverse, lengths, torus, start, entry, seen, near)):
            e = near[q]
            dx, dy, dz = px - form[e, 0], py - form[e, 1], pz - form[e, 2]
            for image in range(images * images):
                ax = shift_to(dx, lengths[0], np.float64(lengths[0]), image % 2) if torus else dx
                ay = shift_to(dy, lengths[1], np.float64(lengths[1]), image // 2) if torus else dy
                t = ray(form, e, ax, ay, dz, wx, wy, wz)
                if t >= free:
                    continue
                if t == 0:
                    _, ox, oy, oz = contact(point, 0, form, e, ax, ay, dz, volume, 1.0)
                    if ox * wx + oy * wy + oz * wz >= 0:  # on its way out
                        continue
                free = t
        if free < 1:
            share[i] = np.float32(max(free - SHORT, 0.0))
            for k in range(3):
                way[i, k] *= share[i]
