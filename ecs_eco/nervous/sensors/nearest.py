"""The sensor that sees the nearest body of a kind."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.compiled.elementary import arrays, scalars
from ecs_eco.compiled.jit import lone_njit
from ecs_eco.compiled.per_row import of_row
from ecs_eco.components import Shape
from ecs_eco.nervous.sensors.kin import nearest_kin
from ecs_eco.nervous.sensors.sense import Sense, in_light, of_sensor, own_range, place_of
from ecs_eco.space import sight
from ecs_eco.space.bodies import merged, opaque_ground, opaque_kinds, relief, solids, tops
from ecs_eco.space.index import Index
from ecs_eco.space.nearest import nearest, seek
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.solid_sight import nearest_in_sight

if TYPE_CHECKING:
    from ecs_eco.compiled.per_row import Number
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

NO_HEIGHTS = np.float32(0.0), np.float32(0.0)  # of eyes and tops, if no hill blocks sight


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

    They are measured from a place on the body, `at`, to the center of a sphere, or to the nearest point of a
    box or of the axis of a capsule. With `by_light` [m] it sees as far as blind + by_light × light at its
    eye, and never further than without. With `kin` only relatives count.
    """
    shared: Any = np.float32(reach)
    view, centred = half_view(fov), not any(map(np.float32, at[:3]))
    alike, selective = by_light is None and kin is None and centred, occlusion or narrow(view)

    def sense(world: SpatialWorld, table: Table, seekers: Seekers, out: np.ndarray, column: int) -> None:
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
        places: Any = targets.x, targets.y, targets.z
        entries, distance2, found = np.empty(seekers.n, np.int32), np.empty(seekers.n, np.float32), False
        hiding, seen = opaque_kinds(world) if occlusion else ((), ()), (space.volume, own, out.T, column)
        if kin is None and (Shape in other or (hiding[1] and solids(world, hiding[1]).uid.size > 0)):
            places, looks_again = (
                look(
                    world,
                    table,
                    seekers,
                    eye,
                    target,
                    radius,
                    cos_half_fov,
                    occlusion,
                    hiding,
                    entries,
                    distance2,
                ),
                False,
            )
        elif kin is not None or eye[0] is not mine.x:
            entries, distance2 = nearest_kin(
                seekers, table, other, targets, kin, eye, own, cos_half_fov, world.split
            )
            looks_again, found = occlusion and kin is None, True
        elif not looks_again:
            return nearest(
                mine, targets, radius, entries, distance2, world.split, see, (seekers.cos, seekers.sin, *seen)
            )
        if looks_again:
            look_again(
                world,
                table,
                seekers,
                eye,
                other,
                targets,
                radius,
                cos_half_fov,
                occlusion,
                hiding[0],
                entries,
                distance2,
                found,
                seen,
            )
        else:
            world.split(
                _bearings,
                seekers.n,
                *eye,
                seekers.cos,
                seekers.sin,
                *places,
                entries,
                distance2,
                space.lengths,
                space.torus,
                *seen,
            )

    sense.by_light = by_light is not None  # type: ignore[attr-defined]
    return sense


def half_view(fov: Number) -> Any:
    """Return the cosine of half a field of view [rad], f32, or f32[n] of many; −2 for all directions."""
    if isinstance(fov, np.ndarray):
        return np.where(fov >= 2 * math.pi - 1e-5, -2.0, arrays.cos(fov / 2)).astype(np.float32)
    return np.float32(-2.0 if fov >= 2 * math.pi - 1e-5 else scalars.cos(fov / 2))


def narrow(cos_half_fov: Number) -> bool:
    """Return whether any field of view is less than all directions, by the cosine of its half."""
    return bool((cos_half_fov.max(initial=-2) if isinstance(cos_half_fov, np.ndarray) else cos_half_fov) > -1)


def look(
    world: SpatialWorld,
    table: Table,
    seekers: Seekers,
    eye: tuple[np.ndarray, ...],
    target: str,
    radius: float,
    cos_half_fov: Number,
    occlusion: bool,
    hiding: tuple[tuple[str, ...], tuple[str, ...]],
    entries: np.ndarray,
    distance2: np.ndarray,
) -> tuple[np.ndarray, ...]:
    """Return the point of the nearest body of a kind that is nearest to each seeker's eye: x, y, z f32[n]
    [m], if some bodies are capsules or boxes; write its entry i32[n], that of seeker i is i, −1 if it sees
    none; and the square of its distance f32[n] [m^2]. `hiding` are the kinds of bodies that block sight."""
    mine, space, (ground, inverse) = seekers.index, world.space, opaque_ground(world)
    targets, spheres, others = solids(world, [target]), merged(world, hiding[0]), solids(world, hiding[1])
    places = tuple(np.zeros(seekers.n, np.float32) for _ in range(3))
    world.split(
        nearest_in_sight,
        seekers.n,
        *eye,
        mine.uid,
        seekers.cos,
        seekers.sin,
        targets.form,
        targets.uid,
        *targets.cells,
        occlusion,
        spheres.x,
        spheres.y,
        spheres.z,
        spheres.radius,
        spheres.uid,
        spheres.start,
        np.float32(spheres.largest),
        others.form,
        others.uid,
        *others.cells,
        *space.shape,
        space.inverse,
        space.lengths,
        space.torus,
        space.volume,
        np.float32(radius),
        cos_half_fov,
        ground,
        inverse,
        relief(world),
        tops(table, seekers.rows),
        *places,
        entries,
        distance2,
    )
    return places


def look_again(
    world: SpatialWorld,
    table: Table,
    seekers: Seekers,
    eye: tuple[np.ndarray, ...],
    other: Table,
    targets: Index,
    radius: float,
    cos_half_fov: Number,
    occlusion: bool,
    hiding: tuple[str, ...],
    entries: np.ndarray,
    distance2: np.ndarray,
    found: bool,
    seen: tuple[Any, ...],
) -> None:
    """Replace the nearest spheres of a kind, `found` or not yet, that are out of view or hidden by visible
    ones; write direction and nearness as `_bearings` does with `seen`."""
    mine, space, height = seekers.index, world.space, relief(world)
    ground, inverse = opaque_ground(world)
    bodies: Any = merged(world, hiding) if occlusion else targets
    radii = bodies.radius if occlusion else targets.x
    largest = np.float32(bodies.largest if occlusion else 0.0)
    heights: Any = NO_HEIGHTS
    if height.size > 1:
        heights = tops(table, seekers.rows), tops(other, targets.rows)
    nx, ny, nz = space.shape
    world.split(
        see_clearly,
        seekers.n if found else ny * nz,
        *eye,
        mine.start,
        mine.uid,
        seekers.cos,
        seekers.sin,
        targets.x,
        targets.y,
        targets.z,
        targets.start,
        targets.uid,
        mine is targets,
        space.reach(radius),
        nx,
        ny,
        nz,
        space.lengths,
        space.torus,
        mine.flat and targets.flat,
        np.float32(radius * radius),
        found,
        bodies.x,
        bodies.y,
        bodies.z,
        radii,
        bodies.uid,
        bodies.start,
        occlusion,
        largest,
        space.inverse,
        np.float32(radius),
        cos_half_fov,
        ground,
        inverse,
        height,
        *heights,
        entries,
        distance2,
        *seen,
        work=(1 if found else 3) * seekers.n,
    )


@lone_njit
def see_clearly(
    first,
    last,
    ox,
    oy,
    oz,
    ostart,
    ou,
    cos,
    sin,
    tx,
    ty,
    tz,
    tstart,
    tu,
    same,
    k,
    nx,
    ny,
    nz,
    lengths,
    torus,
    flat,
    radius2,
    found,
    bx,
    by,
    bz,
    br,
    bu,
    bstart,
    occlusion,
    largest,
    inverse,
    radius,
    cos_half_fov,
    ground,
    ground_inverse,
    height,
    eye,
    top,
    entries,
    distance2,
    volume,
    own,
    out,
    column,
):
    """Run `seek` for the seekers in the rows of cells first … last − 1, or for those seekers in `found`;
    then `nearest_visible`, direction and nearness of the result."""
    if not found:
        seek(
            first,
            last,
            ox,
            oy,
            oz,
            ostart,
            tx,
            ty,
            tz,
            tstart,
            same,
            k,
            nx,
            ny,
            nz,
            lengths,
            torus,
            flat,
            radius2,
            entries,
            distance2,
        )
        first, last = ostart[first * nx], ostart[last * nx]
    sight.nearest_visible(
        first,
        last,
        ox,
        oy,
        oz,
        ou,
        cos,
        sin,
        tx,
        ty,
        tz,
        tu,
        tstart,
        bx,
        by,
        bz,
        br,
        bu,
        bstart,
        occlusion,
        largest,
        nx,
        ny,
        nz,
        inverse,
        lengths,
        torus,
        k,
        radius,
        cos_half_fov,
        ground,
        ground_inverse,
        height,
        eye,
        top,
        entries,
        distance2,
    )
    _bearings(
        first,
        last,
        ox,
        oy,
        oz,
        cos,
        sin,
        tx,
        ty,
        tz,
        entries,
        distance2,
        lengths,
        torus,
        volume,
        own,
        out,
        column,
    )


@lone_njit
def see(
    first,
    last,
    ox,
    oy,
    oz,
    ostart,
    tx,
    ty,
    tz,
    tstart,
    same,
    k,
    nx,
    ny,
    nz,
    lengths,
    torus,
    flat,
    radius2,
    target,
    distance2,
    cos,
    sin,
    volume,
    radius,
    out,
    column,
):
    """Run `seek` for the seekers in the rows of cells first … last − 1, then compute direction and
    nearness of the result."""
    seek(
        first,
        last,
        ox,
        oy,
        oz,
        ostart,
        tx,
        ty,
        tz,
        tstart,
        same,
        k,
        nx,
        ny,
        nz,
        lengths,
        torus,
        flat,
        radius2,
        target,
        distance2,
    )
    _bearings(
        ostart[first * nx],
        ostart[last * nx],
        ox,
        oy,
        oz,
        cos,
        sin,
        tx,
        ty,
        tz,
        target,
        distance2,
        lengths,
        torus,
        volume,
        radius,
        out,
        column,
    )


@lone_njit
def _bearings(
    first,
    last,
    ox,
    oy,
    oz,
    cos,
    sin,
    tx,
    ty,
    tz,
    entries,
    distance2,
    lengths,
    torus,
    volume,
    radius,
    out,
    column,
):
    """Write direction and nearness, 0 if no target is in range; `radius` f32[n], or one for all; no
    branches and unsigned indices, so that it compiles to vector code."""
    zero, one, near = np.float32(0.0), np.float32(1.0), column + (3 if volume else 2)
    if tx.size == 0:
        out[column : near + 1, first:last] = 0
        return
    for k in range(last - first):
        i = np.uint64(first + k)
        reach = of_row(radius, i)
        none = (entries[i] < 0) | (distance2[i] > reach * reach)
        j = np.uint32(max(entries[i], 0))
        dx, dy, dz = sight.offset(ox[i], oy[i], oz[i], tx[j], ty[j], tz[j], lengths, torus)
        distance = np.sqrt(distance2[i])
        inverse = one / max(distance, np.float32(1e-6))
        out[column, i] = zero if none else (dx * cos[i] + dy * sin[i]) * inverse
        out[column + 1, i] = zero if none else (dy * cos[i] - dx * sin[i]) * inverse
        if volume:
            out[column + 2, i] = zero if none else dz * inverse
        out[near, i] = zero if none else one - distance / reach
