"""The sensor that sees the nearest body of a kind."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Shape
from ecs_eco.engine.elementary import arrays, scalars
from ecs_eco.engine.jit import lone_njit
from ecs_eco.nervous.sensors.kin import nearest_kin
from ecs_eco.nervous.sensors.sense import Seekers, Sense, in_light, of_sensor, own_range, place_of
from ecs_eco.space import sight
from ecs_eco.space.bodies import has_opaque_solids, opaque, opaque_ground, opaque_solids, relief, solids, tops
from ecs_eco.space.nearest import nearest
from ecs_eco.space.solid_sight import nearest_in_sight

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def see_nearest(target: str, reach: float, fov: float, occlusion: bool, number: int = 0,
                by_light: float | None = None, blind: float = 0.0, kin: str | None = None,
                at: Sequence[float] = ()) -> Sense:
    """See the nearest of a kind: its direction in the body's frame, as a unit vector, and 1 − distance/reach.

    They are those from a place on the body, `at`, to the centre of a sphere, or to the nearest place of a box
    or of the axis of a capsule.
    With `by_light` [m] it sees as far as blind + by_light × light at its eye [m],
    and never further than without. With `kin` only relatives count.
    """
    def sense(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        radius, own = own_range(table, seekers, number, reach)
        targets, mine = world.index(world.tables[target]), seekers.index
        cos_half_fov = half_view(of_sensor(table, seekers, number, fov=fov)[0])
        eye = place_of(table, seekers, number, at, world.space)
        elsewhere = eye[0] is not mine.x
        if by_light is not None:
            own = in_light(world, table, seekers, number, eye, own, by_light, blind)
            radius = max(float(own.max(initial=0.0)), 1e-6)
        if kin is None and (Shape in world.tables[target] or (occlusion and has_opaque_solids(world))):
            places, entries, distance2 = look(world, table, seekers, eye, target, radius, cos_half_fov,
                                                occlusion)
            world.split(_bearings, seekers.n, *eye, seekers.cos, seekers.sin, *places,
                        entries, distance2, world.space.lengths, world.space.torus, world.space.volume, own,
                        out.T, column)
            return
        if kin is None and not elsewhere:
            entries, distance2 = np.empty(seekers.n, np.int32), np.empty(seekers.n, np.float32)
            nearest(mine, targets, radius, entries, distance2, world.split)
        else:
            entries, distance2 = nearest_kin(seekers, table, world.tables[target], targets, kin, eye, own,
                                             cos_half_fov, world.split)
        if kin is None and (occlusion or (not elsewhere and narrow(cos_half_fov))):
            space, ground, inverse = world.space, *opaque_ground(world)
            bodies: Any = opaque(world) if occlusion else targets
            radii = bodies.radius if occlusion else targets.x
            largest = np.float32(bodies.largest if occlusion else 0.0)
            world.split(sight.nearest_visible, seekers.n, *eye, mine.uid, seekers.cos, seekers.sin, targets.x,
                        targets.y, targets.z, targets.uid, targets.start, bodies.x,
                        bodies.y, bodies.z, radii, bodies.uid, bodies.start, occlusion, largest, *space.shape,
                        space.inverse, space.lengths, space.torus, space.reach(radius), np.float32(radius),
                        cos_half_fov, ground, inverse, relief(world), tops(table, seekers.rows),
                        tops(world.tables[target], targets.rows), entries, distance2)
        world.split(_bearings, seekers.n, *eye, seekers.cos, seekers.sin, targets.x,
                    targets.y, targets.z, entries,
                    distance2, world.space.lengths, world.space.torus, world.space.volume, own, out.T,
                    column)

    sense.by_light = by_light is not None  # type: ignore[attr-defined]
    return sense


def half_view(fov: Any) -> Any:
    """Return the cosine of half a field of view [rad], f32, or f32[n] of many; −2 all round."""
    if isinstance(fov, np.ndarray):
        return np.where(fov >= 2 * math.pi - 1e-5, -2.0, arrays.cos(fov / 2)).astype(np.float32)
    return np.float32(-2.0 if fov >= 2 * math.pi - 1e-5 else scalars.cos(fov / 2))


def narrow(cos_half_fov: Any) -> bool:
    """Return whether some field of view is less than all round, by the cosine of its half."""
    return bool((cos_half_fov.max(initial=-2) if isinstance(cos_half_fov, np.ndarray) else cos_half_fov) > -1)


def look(world: "SpatialWorld", table: "Table", seekers: Seekers, eye: tuple[np.ndarray, ...], target: str,
         radius: float, cos_half_fov: Any,
         occlusion: bool) -> tuple[tuple[np.ndarray, ...], np.ndarray, np.ndarray]:
    """Return the place of the nearest of a kind that is nearest to each seeker's eye: x, y, z f32[n] [m], if
    some bodies are capsules or boxes; its entry i32[n], that of seeker i is i, −1 where it sees none; and the
    square of its distance f32[n] [m^2]."""
    entries, distance2 = np.empty(seekers.n, np.int32), np.empty(seekers.n, np.float32)
    mine, space, (ground, inverse) = seekers.index, world.space, opaque_ground(world)
    targets, spheres, others = solids(world, [target]), opaque(world), opaque_solids(world)
    places = tuple(np.zeros(seekers.n, np.float32) for _ in range(3))
    world.split(nearest_in_sight, seekers.n, *eye, mine.uid, seekers.cos, seekers.sin,
                targets.form, targets.uid, *targets.cells, occlusion, spheres.x, spheres.y, spheres.z,
                spheres.radius, spheres.uid, spheres.start, np.float32(spheres.largest), others.form,
                others.uid, *others.cells, *space.shape, space.inverse, space.lengths, space.torus,
                space.volume, np.float32(radius), cos_half_fov, ground, inverse, relief(world),
                tops(table, seekers.rows), *places, entries, distance2)
    return places, entries, distance2


@lone_njit
def _bearings(first, last, ox, oy, oz, cos, sin, tx, ty, tz, entries, distance2, lengths, torus, volume,
              radius, out, column):
    """Write direction and nearness, 0 where nobody is in range; without branches and with unsigned indices,
    so that it becomes vector code."""
    zero, one, near = np.float32(0.0), np.float32(1.0), column + (3 if volume else 2)
    if tx.size == 0:
        out[column : near + 1, first:last] = 0
        return
    for k in range(last - first):
        i = np.uint64(first + k)
        none = (entries[i] < 0) | (distance2[i] > radius[i] * radius[i])
        j = np.uint32(max(entries[i], 0))
        dx, dy, dz = sight.offset(ox[i], oy[i], oz[i], tx[j], ty[j], tz[j], lengths, torus)
        distance = np.sqrt(distance2[i])
        inverse = one / max(distance, np.float32(1e-6))
        out[column, i] = zero if none else (dx * cos[i] + dy * sin[i]) * inverse
        out[column + 1, i] = zero if none else (dy * cos[i] - dx * sin[i]) * inverse
        if volume:
            out[column + 2, i] = zero if none else dz * inverse
        out[near, i] = zero if none else one - distance / radius[i]
