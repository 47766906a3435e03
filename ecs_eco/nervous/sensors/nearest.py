"""The sensor that sees the nearest body of a kind."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Shape
from ecs_eco.engine.jit import njit
from ecs_eco.nervous.sensors.kin import nearest_kin
from ecs_eco.nervous.sensors.sense import Seekers, Sense, of_sensor, own_range
from ecs_eco.space import sight
from ecs_eco.space.bodies import opaque, opaque_solids, rocks, solids
from ecs_eco.space.nearest import nearest
from ecs_eco.space.solid_sight import nearest_in_sight

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def see_nearest(target: str, reach: float, fov: float, occlusion: bool, number: int = 0,
                by_light: float | None = None, blind: float = 0.0, kin: str | None = None) -> Sense:
    """See the nearest of a kind: its direction in the body's frame, as a unit vector, and 1 − distance/reach.

    That is the centre of a sphere, of a capsule or box the place of its axis or of the box that is nearest.
    With `by_light` [m] it sees as far as blind + by_light × light at its eye [m],
    and never further than without. With `kin` only relatives count.
    """
    cos_half_fov = np.float32(-2.0 if fov >= 2 * math.pi - 1e-5 else math.cos(fov / 2))

    def sense(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        radius, own = own_range(table, seekers, number, reach)
        targets, mine = world.index(world.tables[target]), seekers.index
        if by_light is not None:
            light = world.surroundings("light", mine.x, mine.y, mine.z)
            near, far = of_sensor(table, seekers, number, blind=np.float32(blind), sight=np.float32(by_light))
            own = np.minimum(own, near + far * light)
            radius = max(float(own.max(initial=0.0)), 1e-6)
        if kin is None and (Shape in world.tables[target] or (occlusion and opaque_solids(world).uid.size)):
            places, entries, distance2 = look(world, seekers, target, radius, cos_half_fov, occlusion)
            world.split(_bearings, seekers.n, mine.x, mine.y, mine.z, seekers.cos, seekers.sin, *places,
                        entries, distance2, world.space.lengths, world.space.torus, world.space.volume, own,
                        out, column)
            return
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


def look(world: "SpatialWorld", seekers: Seekers, target: str, radius: float, cos_half_fov: np.float32,
         occlusion: bool) -> tuple[tuple[np.ndarray, ...], np.ndarray, np.ndarray]:
    """Return where the nearest place of the nearest of a kind is for each seeker, x, y, z f32[n] [m], where
    some bodies are capsules or boxes; its entry i32[n], that of seeker i is i, −1 where it sees none; and the
    square of its distance f32[n] [m^2]."""
    entries, distance2 = np.empty(seekers.n, np.int32), np.empty(seekers.n, np.float32)
    mine, space, (ground, inverse) = seekers.index, world.space, rocks(world)
    targets, spheres, others = solids(world, [target]), opaque(world), opaque_solids(world)
    places = tuple(np.zeros(seekers.n, np.float32) for _ in range(3))
    world.split(nearest_in_sight, seekers.n, mine.x, mine.y, mine.z, mine.uid, seekers.cos, seekers.sin,
                targets.form, targets.uid, *targets.cells, occlusion, spheres.x, spheres.y, spheres.z,
                spheres.radius, spheres.uid, spheres.start, np.float32(spheres.largest), others.form,
                others.uid, *others.cells, *space.shape, space.inverse, space.lengths, space.torus,
                space.volume, np.float32(radius), cos_half_fov, ground, inverse, *places, entries, distance2)
    return places, entries, distance2


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
