"""Positions for newborns: drawn near their parents or anywhere, free of obstacles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.compiled.elementary import power
from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Body, Position, Shape
from ecs_eco.engine import random
from ecs_eco.engine.random import draw
from ecs_eco.genomes.own_values import own_values
from ecs_eco.life.sizes import radii_differ
from ecs_eco.space.barriers import POINT
from ecs_eco.space.bodies import ground_of, solids
from ecs_eco.space.geometry import Extent, into
from ecs_eco.space.index import Entries
from ecs_eco.space.shapes import touching
from ecs_eco.space.sight import gather, offset
from ecs_eco.space.solids import Solids, around as solids_around
from ecs_eco.space.terrain import ROCK, WATER, Ground, ground_at

if TYPE_CHECKING:
    from ecs_eco.config.models.reproduction import AnyBearing
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

TRIES = 8  # positions tried before a birth fails
APART = random.LOT + (1 << 8)  # purpose of the draws that order newborns for `keep_apart`


class Around(NamedTuple):
    """Possible positions of newborns: within `dispersal` [m] of x, y, z f32[k] [m] (negative: anywhere), and
    at least `spacing` [m] from other members of their species. Both are f32, or both are f32[k]."""

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    dispersal: Any
    spacing: Any

    def of(self, which: np.ndarray) -> Around:
        """Return the possible positions of some newborns, i64[n]."""
        x, y, z, dispersal, spacing = self
        if isinstance(spacing, np.ndarray):
            dispersal, spacing = dispersal[which], spacing[which]
        return Around(x[which], y[which], z[which], dispersal, spacing)


def range_of(table: Table, way: AnyBearing) -> tuple[Any, Any]:
    """Return the `dispersal` and `spacing` of a table's newborns, as in `Around`: both f32, or both f32[high]
    by the parent's row."""
    spacing: Any = np.float32(way.spacing)
    near: Any = np.float32(-1.0)
    if way.place != "anywhere":
        near = np.float32(way.dispersal or 4 * bound_of(table) * float(table.defaults[Body]["radius"]))
        if way.dispersal is None and radii_differ(table):
            near = np.float32(4 * bound_of(table)) * table[Body].radius[: table.high]
            spacing = np.full(table.high, spacing)
    if table.species.traits:
        spacing, near = own_values(table, {"reproduction.spacing": spacing, "reproduction.dispersal": near})
    return near, spacing


def around(table: Table, way: AnyBearing, parents: np.ndarray) -> Around:
    """Return the possible positions of newborns of parents in rows i64[k]."""
    p, (near, spacing) = table[Position], range_of(table, way)
    if isinstance(spacing, np.ndarray):
        spacing, near = spacing[parents], near[parents]
    return Around(p.x[parents], p.y[parents], p.z[parents], near, spacing)


def find_places(table: Table, world: SpatialWorld, where: Around, identity: np.ndarray) -> np.ndarray:
    """Find a position for each newborn, drawn for `identity` u64[k]: (x, y, z, whether it is free), f32[k,
    4]."""
    space, ground = world.space.extent, ground_of(world)
    out, free = np.zeros((identity.size, 4), np.float32), np.zeros(identity.size, np.bool_)
    homeless = random.by_lot(world.key, identity, APART)
    for attempt in range(TRIES):
        draw_places(homeless, identity, where, space, ground, world.key, attempt, out, free)
        forbidden = _forbidden(table, world, where, homeless, out, free)
        if world.bands.divided:
            forbidden = world.bands.either(forbidden)
        left = keep_apart(homeless, where.spacing, space, *forbidden, free, out)
        homeless = homeless[:left]
        if not homeless.size:
            return out
    out[homeless, 3] = 0
    return out


def _forbidden(
    table: Table, world: SpatialWorld, where: Around, who: np.ndarray, out: np.ndarray, free: np.ndarray
) -> np.ndarray:
    """Return whether each newborn in `who` i64[n] is too near to a member of its species, and whether a body
    occupies its position: bool[2, n]; false for positions in other processes."""
    space, own, spacing = world.space, world.index(table), where.spacing
    asked, forbidden = free, np.zeros((2, who.size), np.bool_)
    if world.bands.divided:
        asked = free.copy()
        asked[who] &= world.bands.holds(out[who, 1])
    crowded, taken = forbidden
    widest = float(spacing.max() if isinstance(spacing, np.ndarray) else spacing)
    if widest > 0:
        _crowded(who, asked, out, spacing, own.entries, space.reach(widest), space.extent, crowded)
    radius = radius_of(table)
    for other in world.tables.values():
        if takes_room(other):
            if Shape in other.columns:
                bodies = solids(world, [other.name])
                reach = np.float32(radius)
                _occupied_by_solids(who, asked, out, bodies, space.extent, reach, POINT, taken)
                continue
            index = own if other is table else world.index(other)
            apart = np.float32(radius) + other[Body].radius[index.rows]
            furthest = space.reach(float(np.maximum.reduce(apart, initial=0)))
            _occupied(who, asked, out, index.entries, apart, furthest, space.extent, taken)
    return forbidden


def takes_room(table: Table) -> bool:
    """Return whether newborns are kept clear of a table's bodies, which is true if the bodies are opaque and
    the table was not built by hand."""
    kind = table.species
    return table.n > 0 and kind.section is not None and kind.body.opaque and Body in table.columns


def radius_of(table: Table) -> float:
    """Return the radius [m] of the smallest sphere around a newborn, ignoring its genes."""
    radius, way = float(table.defaults[Body]["radius"]), table.species.growth
    if Shape in table:
        radius *= bound_of(table)
    return radius if way is None else radius * float(power(np.float64(way.newborn), 1 / 3))


def bound_of(table: Table) -> float:
    """Return the radius of the smallest sphere around a body of a table, in units of the body's radius."""
    if Shape not in table:
        return 1.0
    form = {field: float(value) for field, value in table.defaults[Shape].items()}
    return form.pop("rounding") + math.hypot(*form.values())


@njit
def draw_places(
    homeless: np.ndarray,
    identity: np.ndarray,
    where: Around,
    space: Extent,
    ground: Ground,
    key: np.uint64,
    attempt: int,
    out: np.ndarray,
    free: np.ndarray,
) -> None:
    """Draw a position for each newborn i in `homeless`; free[i] is true unless water or rock covers it."""
    salt, lengths, torus = attempt << 10, space.lengths, space.torus
    for i in homeless:
        u, v, w = (
            draw(key, identity[i], random.PLACE + salt),
            draw(key, identity[i], random.PLACE + (1 << 8) + salt),
            draw(key, identity[i], random.PLACE + (2 << 8) + salt),
        )
        furthest = of_row(where.dispersal, i)
        if furthest < 0:
            x, y, z = u * lengths[0], v * lengths[1], w * lengths[2]
        else:
            r, a = furthest * np.sqrt(u), np.float32(6.2831855) * v
            x, y = (
                into(where.x[i] + r * np.cos(a), lengths[0], torus),
                into(where.y[i] + r * np.sin(a), lengths[1], torus),
            )
            z = (
                into(where.z[i] + furthest * (np.float32(2) * w - np.float32(1)), lengths[2], False)
                if space.volume
                else where.z[i]
            )
        free[i] = True
        if ground.kind.size > 1:  # newborns can appear on fences
            kind = ground_at(ground, x, y)
            free[i] = kind not in (WATER, ROCK)
        out[i, 0], out[i, 1], out[i, 2] = x, y, z


@njit
def _crowded(
    who: np.ndarray,
    asked: np.ndarray,
    places: np.ndarray,
    spacing: Number,
    own: Entries,
    reach: int,
    space: Extent,
    crowded: np.ndarray,
) -> None:
    """Mark the positions with a member of the species within `spacing`, for newborns i in `who` that are
    checked."""
    ox, oy, oz = own.x, own.y, own.z
    near = np.empty(ox.size, np.int64)
    for k in range(who.size):
        i = who[k]
        x, y, z, apart = places[i, 0], places[i, 1], places[i, 2], of_row(spacing, i)
        if not (asked[i] and apart > 0):
            continue
        n = gather(x, y, z, reach, own, space, near)
        for q in range(n):
            dx, dy, dz = offset(x, y, z, ox[near[q]], oy[near[q]], oz[near[q]], space)
            if dx * dx + dy * dy + dz * dz < apart * apart:
                crowded[k] = True
                break


@njit
def keep_apart(
    homeless: np.ndarray,
    spacing: Number,
    space: Extent,
    crowded: np.ndarray,
    taken: np.ndarray,
    free: np.ndarray,
    out: np.ndarray,
) -> int:
    """Accept the position of each newborn i in `homeless` (out[i, 3] = 1) if it is free and not crowded, and
    no other newborn of this tick has a position within `spacing`. Move newborns whose position is occupied by
    a body to the front of `homeless`, and return their number."""
    n = 0
    for k in range(homeless.size):
        if crowded[k]:
            free[homeless[k]] = False
        out[homeless[k], 3] = 0
    for i in homeless:
        apart, x, y, z = of_row(spacing, i), out[i, 0], out[i, 1], out[i, 2]
        for j in range(len(out) if free[i] and apart > 0 else 0):
            dx, dy, dz = offset(x, y, z, out[j, 0], out[j, 1], out[j, 2], space)
            if out[j, 3] > 0 and dx * dx + dy * dy + dz * dz < apart * apart:
                free[i] = False
        out[i, 3] = 1 if free[i] else 0
    for k in range(homeless.size):
        if taken[k] and out[homeless[k], 3] > 0:
            homeless[n] = homeless[k]
            n += 1
    return n


@njit
def _occupied(
    who: np.ndarray,
    asked: np.ndarray,
    places: np.ndarray,
    others: Entries,
    apart: np.ndarray,
    reach: int,
    space: Extent,
    taken: np.ndarray,
) -> None:
    ox, oy, oz = others.x, others.y, others.z
    near = np.empty(ox.size, np.int64)
    for k in range(who.size):
        i = who[k]
        if taken[k] or not asked[i]:
            continue
        x, y, z = places[i, 0], places[i, 1], places[i, 2]
        n = gather(x, y, z, reach, others, space, near)
        for q in range(n):
            e = near[q]
            dx, dy, dz = offset(x, y, z, ox[e], oy[e], oz[e], space)
            if dx * dx + dy * dy + dz * dz < apart[e] * apart[e]:
                taken[k] = True
                break


@njit
def _occupied_by_solids(
    who: np.ndarray,
    asked: np.ndarray,
    places: np.ndarray,
    others: Solids,
    space: Extent,
    radius: np.float32,
    point: np.ndarray,
    taken: np.ndarray,
) -> None:
    """Like `_occupied`, but for capsules and boxes, whose surfaces must be at least `radius` [m] from a free
    position."""
    form, r = others.form, np.float64(radius)
    near, seen = np.empty(len(form), np.int64), np.zeros(len(form) + 1, np.int64)
    for k in range(who.size):
        i = who[k]
        if taken[k] or not asked[i]:
            continue
        x, y, z = np.float64(places[i, 0]), np.float64(places[i, 1]), np.float64(places[i, 2])
        n = solids_around(x, y, z, r, r, r, others, space, seen, near)
        for q in range(n):
            e = near[q]
            gap, _, _, _ = touching(point, 0, form, e, x - form[e, 0], y - form[e, 1], z - form[e, 2], space)
            if gap < r:
                taken[k] = True
                break
