"""The sensor that sees the nearest body of a kind."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.engine.jit import njit
from ecs_eco.nervous.sensors.kin import nearest_kin
from ecs_eco.nervous.sensors.sense import Seekers, Sense, own_range
from ecs_eco.space import sight
from ecs_eco.space.bodies import opaque, rocks
from ecs_eco.space.nearest import nearest

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def see_nearest(target: str, reach: float, fov: float, occlusion: bool, number: int = 0,
                by_light: float | None = None, blind: float = 0.0, kin: str | None = None) -> Sense:
    """See the nearest of a kind: its direction in the body's frame, as a unit vector, and 1 − distance/reach.

    With `by_light` [m] it sees as far as blind + by_light × light at its eye [m],
    and never further than without. With `kin` only relatives count.
    """
    cos_half_fov = np.float32(-2.0 if fov >= 2 * math.pi - 1e-5 else math.cos(fov / 2))

    def sense(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        radius, own = own_range(table, seekers, number, reach)
        targets, mine = world.index(world.tables[target]), seekers.index
        if by_light is not None:
            light = world.surroundings("light", mine.x, mine.y, mine.z)
            own = np.minimum(own, np.float32(blind) + np.float32(by_light) * light)
            radius = max(float(own.max(initial=0.0)), 1e-6)
        if kin is None:
            entries, distance2 = np.empty(seekers.n, np.int32), np.empty(seekers.n, np.float32)
            nearest(mine, targets, radius, entries, distance2, world.split)
        else:
            entries, distance2 = nearest_kin(seekers, table, world.tables[target], targets, kin, own,
                                             cos_half_fov, world.split)
        if kin is None and (occlusion or cos_half_fov > -1):
            space, ground, inverse = world.space, *rocks(world)
            bodies: Any = opaque(world) if occlusion else targets
            radii = bodies.radius if occlusion else targets.x
            largest = np.float32(bodies.largest if occlusion else 0.0)
            world.split(sight.nearest_visible, seekers.n, mine.x, mine.y, mine.z, mine.uid, seekers.cos,
                        seekers.sin, targets.x, targets.y, targets.z, targets.uid, targets.start, bodies.x,
                        bodies.y, bodies.z, radii, bodies.uid, bodies.start, occlusion, largest, *space.shape,
                        space.inverse, space.lengths, space.torus, space.reach(radius), np.float32(radius),
                        cos_half_fov, ground, inverse, entries, distance2)
        world.split(_bearings, seekers.n, mine.x, mine.y, mine.z, seekers.cos, seekers.sin, targets.x,
                    targets.y, targets.z, entries,
                    distance2, world.space.lengths, world.space.torus, world.space.volume, own, out, column)

    sense.by_light = by_light is not None  # type: ignore[attr-defined]
    return sense


@njit
def _bearings(first, last, ox, oy, oz, cos, sin, tx, ty, tz, entries, distance2, lengths, torus, volume,
              radius, out, column):
    for i in range(first, last):
        j = entries[i]
        if j < 0 or distance2[i] > radius[i] * radius[i]:
            out[i, column] = 0
            out[i, column + 1] = 0
            out[i, column + 2] = 0
            if volume:
                out[i, column + 3] = 0
            continue
        dx, dy, dz = sight.offset(ox[i], oy[i], oz[i], tx[j], ty[j], tz[j], lengths, torus)
        distance = np.sqrt(distance2[i])
        inverse = np.float32(1.0) / max(distance, np.float32(1e-6))
        out[i, column] = (dx * cos[i] + dy * sin[i]) * inverse
        out[i, column + 1] = (dy * cos[i] - dx * sin[i]) * inverse
        c = column + 2
        if volume:
            out[i, c] = dz * inverse
            c += 1
        out[i, c] = np.float32(1.0) - distance / radius[i]
