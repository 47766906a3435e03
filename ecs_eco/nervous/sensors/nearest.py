"""The sensor that sees the nearest body of a kind."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.compiled.elementary import arrays, scalars
from ecs_eco.compiled.jit import lone_njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Shape
from ecs_eco.nervous.sensors.kin import nearest_kin
from ecs_eco.nervous.sensors.sense import Sense, in_light, of_sensor, own_range, place_of
from ecs_eco.space.bodies import merged, opaque_ground, opaque_kinds, solids, tops
from ecs_eco.space.geometry import Extent, Places
from ecs_eco.space.index import Entries
from ecs_eco.space.nearest import Found, Search, nearest, search_of, seek
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.sight import Poses, Sight, count_ahead, nearest_visible, offset
from ecs_eco.space.solid_sight import nearest_in_sight
from ecs_eco.space.spheres import NO_SPHERES, Spheres
from ecs_eco.space.terrain import Ground

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

NO_HEIGHT = np.float32(0.0)  # height of eyes and tops if no hill blocks sight
NO_HEIGHTS: tuple[Number, Number] = NO_HEIGHT, NO_HEIGHT


class Bearings(NamedTuple):
    """Output of a sensor, for kernels: direction and nearness."""

    reach: Number  # range f32[n] [m], or one value for all
    out: np.ndarray  # f32[channels, n]
    column: int  # first channel of the sensor


def see_nearest(
    target: str,
    reach: float,
    fov: float,
    occlusion: bool,
    number: int = 0,
    by_light: float | None = None,
    blind: float = 0.0,
    kin: str | None = None,
    at: Sequence[float] = (),
) -> Sense:
    """See the nearest body of a kind: its direction in the body's frame, as a unit vector, and 1 −
    distance/reach.

    Both are measured from a point on the body, `at`, to the center of a sphere, or to the nearest point of a
    box or of a capsule's axis. With `by_light` [m], the range is blind + by_light × light at the eye, but
    never more than the range without it. With `kin`, it sees only relatives.
    """
    shared: Any = np.float32(reach)
    view, centred = half_view(fov), not any(map(np.float32, at[:3]))
    alike, selective = by_light is None and kin is None and centred, occlusion or narrow(view)

    def read(world: SpatialWorld, table: Table, seekers: Seekers, out: np.ndarray, column: int) -> None:
        species, other, mine, space = table.species, world.tables[target], seekers.index, world.space
        targets, radius, own, cos_half_fov, looks_again = world.index(other), reach, shared, view, selective
        if not alike or number in species.own_ranges or number in species.own_places:
            radius, own = own_range(table, seekers, number, reach)
        if species.traits:
            cos_half_fov = half_view(of_sensor(table, seekers, number, fov=fov)[0])
            looks_again = occlusion or narrow(cos_half_fov)
        eye = (
            (mine.x, mine.y, mine.z)
            if centred and number not in species.own_places
            else place_of(table, seekers, number, at, space)
        )
        if by_light is not None:
            own = in_light(world, table, seekers, number, eye, own, by_light, blind)
            radius = max(float(own.max(initial=0.0)), 1e-6)
        places = Places(targets.x, targets.y, targets.z)
        found = Found(np.empty(seekers.n, np.int32), np.empty(seekers.n, np.float32))
        hiding, seen = opaque_kinds(world) if occlusion else ((), ()), Bearings(own, out.T, column)
        poses = seekers.poses if eye[0] is mine.x else seekers.poses_at(*eye)
        known = False
        if kin is None and (Shape in other or (hiding[1] and solids(world, hiding[1]).uid.size > 0)):
            looks_again = False
            how = Sight(np.float32(radius), 0, cos_half_fov, occlusion, tops(table, seekers.rows), NO_HEIGHT)
            places = look(world, poses, target, how, hiding, found)
        elif kin is not None or eye[0] is not mine.x:
            found = nearest_kin(seekers, table, other, targets, kin, eye, own, cos_half_fov, world.split)
            looks_again, known = occlusion and kin is None, True
        elif not looks_again:
            nearest(mine, targets, radius, *found, world.split)
        if looks_again:
            ground, heights = opaque_ground(world), NO_HEIGHTS
            if ground.height.size > 1:
                heights = tops(table, seekers.rows), tops(other, targets.rows)
            _, ny, nz = space.shape
            world.split(
                see_clearly,
                seekers.n if known else ny * nz,
                mine.entries,
                targets.entries,
                space.extent,
                search_of(mine, targets, radius),
                found,
                known,
                poses,
                merged(world, hiding[0]) if occlusion else NO_SPHERES,
                Sight(np.float32(radius), space.reach(radius), cos_half_fov, occlusion, *heights),
                ground,
                seen,
                work=(1 if known else 3) * seekers.n,
            )
        else:
            world.split(_bearings, seekers.n, poses, places, space.extent, found, seen)

    return Sense(read, divisible=by_light is None)


def number_in_view(world: SpatialWorld, table: Table, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of a table, i64[n], and how many targets are within the range and field of view of each
    one's sensor, hidden or not: i32[n]."""
    sensor: Any = table.species.sensors[number]
    seekers, targets = Seekers(world, table), world.index(world.tables[sensor.target])
    widest, own = own_range(table, seekers, number, sensor.range)
    eye = place_of(table, seekers, number, sensor.at, world.space)
    if sensor.sight is not None:
        own = in_light(world, table, seekers, number, eye, own, sensor.sight, sensor.blind)
    view = half_view(of_sensor(table, seekers, number, fov=sensor.fov)[0])
    count, (reach, extent) = np.empty(seekers.n, np.int32), (world.space.reach(widest), world.space.extent)
    poses = seekers.poses_at(*eye)
    world.split(count_ahead, seekers.n, poses, own, view, targets.entries, reach, extent, count)
    return seekers.rows, count


def half_view(fov: Number) -> Any:
    """Return the cosine of half the angle of a field of view [rad]: f32, or f32[n] for n fields of view; −2
    for all directions."""
    if isinstance(fov, np.ndarray):
        return np.where(fov >= 2 * math.pi - 1e-5, -2.0, arrays.cos(fov / 2)).astype(np.float32)
    return np.float32(-2.0 if fov >= 2 * math.pi - 1e-5 else scalars.cos(fov / 2))


def narrow(cos_half_fov: Number) -> bool:
    """Return whether any field of view, given by the cosine of half its angle, covers less than all
    directions."""
    return bool((cos_half_fov.max(initial=-2) if isinstance(cos_half_fov, np.ndarray) else cos_half_fov) > -1)


def look(
    world: SpatialWorld,
    poses: Poses,
    target: str,
    how: Sight,
    hiding: tuple[tuple[str, ...], tuple[str, ...]],
    found: Found,
) -> Places:
    """Return the nearest point of the nearest body of a kind for each seeker's eye, if some bodies are
    capsules or boxes. Seeker i's entry becomes i, or −1 if it sees none. `hiding` are the kinds of bodies
    that block sight."""
    n = found.entry.size
    places = Places(*(np.zeros(n, np.float32) for _ in range(3)))
    world.split(
        nearest_in_sight,
        n,
        poses,
        solids(world, [target]),
        merged(world, hiding[0]),
        solids(world, hiding[1]),
        how,
        opaque_ground(world),
        world.space.extent,
        places,
        found,
    )
    return places


@lone_njit
def see_clearly(
    first: int,
    last: int,
    mine: Entries,
    targets: Entries,
    space: Extent,
    search: Search,
    found: Found,
    known: bool,
    seekers: Poses,
    bodies: Spheres,
    how: Sight,
    ground: Ground,
    seen: Bearings,
) -> None:
    """Run `seek` for the seekers in the rows of cells first … last − 1, unless the result is `known`, then
    `nearest_visible`; compute the direction and nearness of the result."""
    if not known:
        seek(first, last, mine, targets, space, search, found)
        first, last = mine.start[first * space.nx], mine.start[last * space.nx]
    nearest_visible(first, last, seekers, targets, space, bodies, how, ground, found)
    _bearings(first, last, seekers, targets, space, found, seen)


@lone_njit
def _bearings(
    first: int, last: int, seekers: Poses, targets: Places, space: Extent, found: Found, seen: Bearings
) -> None:
    """Write the direction and nearness, both 0 if no target is in range. Branch-free and with unsigned indices,
    so that it vectorizes."""
    ox, oy, oz, _, cos, sin = seekers
    tx, ty, tz, (entries, distance2), (radius, out, column) = targets.x, targets.y, targets.z, found, seen
    zero, one, near = np.float32(0.0), np.float32(1.0), column + (3 if space.volume else 2)
    if tx.size == 0:
        out[column : near + 1, first:last] = 0
        return
    for k in range(last - first):
        i = np.uint64(first + k)
        reach = of_row(radius, i)
        none = (entries[i] < 0) | (distance2[i] > reach * reach)
        j = np.uint32(max(entries[i], 0))
        dx, dy, dz = offset(ox[i], oy[i], oz[i], tx[j], ty[j], tz[j], space)
        distance = np.sqrt(distance2[i])
        inverse = one / max(distance, np.float32(1e-6))
        out[column, i] = zero if none else (dx * cos[i] + dy * sin[i]) * inverse
        out[column + 1, i] = zero if none else (dy * cos[i] - dx * sin[i]) * inverse
        if space.volume:
            out[column + 2, i] = zero if none else dz * inverse
        out[near, i] = zero if none else one - distance / reach
