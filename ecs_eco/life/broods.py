"""Newborns of a few parents among a few thousand organisms: their identities and positions, determined in one
kernel call that checks all possible obstacles.

The result is the same as with `ecs_eco.life.places`, which uses neighbor indexes; these have just been
invalidated by deaths, and updating them would take longer.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Position, Shape
from ecs_eco.engine import random
from ecs_eco.engine.addresses import column_at
from ecs_eco.engine.random import by_lot, draw, mix
from ecs_eco.life.places import APART, TRIES, Around, draw_places, keep_apart, radius_of, range_of, takes_room
from ecs_eco.space.bodies import ground_of
from ecs_eco.space.geometry import Extent
from ecs_eco.space.sight import offset
from ecs_eco.space.terrain import Ground

if TYPE_CHECKING:
    from ecs_eco.compiled.per_row import Number
    from ecs_eco.config.models.reproduction import AnyBearing
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

MOST_PAIRS = 1 << 16  # pairs of a newborn and a possible obstacle; with more pairs, an index is faster


class Brood(NamedTuple):
    """Newborns with positions, ordered by their parents' uids: arrays [n]."""

    which: np.ndarray  # i64, their litters
    identity: np.ndarray  # u64, identify random draws
    mother: np.ndarray  # u64, uids
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    heading: np.ndarray
    energy: np.ndarray


class Others(NamedTuple):
    """Bodies that newborns must not touch, for kernels."""

    table: int  # index of the newborns' table
    columns: np.ndarray  # u64[tables, …], addresses of `SpatialWorld.whereabouts`
    high: np.ndarray  # i64[tables], number of rows to check
    apart: np.ndarray  # f32[tables] [m], smallest distance between surfaces; negative: no limit


def small_brood(
    table: Table,
    world: SpatialWorld,
    way: AnyBearing,
    parents: np.ndarray,
    number: np.ndarray,
    given: np.ndarray,
    n: int,
) -> tuple[Brood, np.ndarray] | None:
    """Return the newborns (of `n`) that have a free position, and how many each parent in rows i64[k] has,
    i64[k], given the arguments of `bring_forth`. Return None if another method must find positions."""
    dispersal, spacing = range_of(table, way)
    others = None if isinstance(spacing, np.ndarray) else in_the_way(table, world, n, spacing > 0)
    if others is None:
        return None
    place, high, apart = others
    which, born = np.empty(n, np.int64), np.zeros(parents.size, np.int64)
    names, values = np.empty((2, n), np.uint64), np.empty((5, n), np.float32)
    m = settle(
        parents,
        number,
        given,
        dispersal,
        spacing,
        Others(place, world.whereabouts(), high, apart),
        world.space.extent,
        ground_of(world),
        world.key,
        which,
        names,
        values,
        born,
    )
    if m < n:
        which, names, values = which[:m], names[:, :m], values[:, :m]
    # one by one, because unpacking an array ends with an IndexError within numpy, which takes longer
    return Brood(which, names[0], names[1], values[0], values[1], values[2], values[3], values[4]), born


def in_the_way(
    table: Table, world: SpatialWorld, n: int, kin: bool
) -> tuple[int, np.ndarray, np.ndarray] | None:
    """Return the index of a table, how many rows of each table to check, and the minimum distance f32 [m]
    from the surfaces of its bodies to a newborn's position (negative: no obstacles); `kin` means that the
    newborn's own species is checked. None if there are many bodies, or bodies other than spheres."""
    tables = world.tables.values()
    high, apart = np.zeros(len(tables), np.int64), np.zeros(len(tables), np.float32) - 1
    pairs, place, radius = 0, 0, radius_of(table)
    for k, other in enumerate(tables):
        opaque = takes_room(other)
        if other is table:
            place = k
        elif not opaque:
            continue
        if opaque:
            if Shape in other or Position not in other:
                return None
            apart[k] = radius
        if opaque or kin:
            high[k] = other.high
            pairs += n * other.high
    return (place, high, apart) if pairs <= MOST_PAIRS else None


@njit
def name(uid, number, which, identity):
    """Write the litter and the identity of each newborn in a tick: its parent's uid for the first newborn of
    a litter, a hash of that uid for the rest."""
    n = 0
    for i in range(uid.size):
        for nth in range(min(number[i], which.size - n)):
            which[n] = i
            identity[n] = uid[i] if nth == 0 else mix(mix(uid[i]) + np.uint64(nth))
            n += 1


@njit
def settle(
    parents: np.ndarray,
    number: np.ndarray,
    given: np.ndarray,
    dispersal: Number,
    spacing: np.float32,
    others: Others,
    space: Extent,
    ground: Ground,
    key: np.uint64,
    which: np.ndarray,
    names: np.ndarray,
    values: np.ndarray,
    born: np.ndarray,
) -> int:
    """Identify the newborns, find a position for each, and write those that have one, in order: `which` is
    the litter, `names` u64[2, n] are identity and mother, and `values` f32[5, n] are position, heading and
    energy. Count the newborns of each parent, and return the total."""
    table, columns = others.table, others.columns
    n, m, uid, rows = which.size, 0, np.empty(parents.size, np.uint64), 0
    for row in parents:
        rows = max(rows, row + 1)
    own, at = column_at(columns[table, 1], np.uint64, rows), np.empty((3, n), np.float32)
    for i in range(parents.size):
        uid[i] = own[parents[i]]
    name(uid, number, which, names[0])
    for axis in range(3):
        column = column_at(columns[table, 2 + axis], np.float32, rows)
        for i in range(n):
            at[axis, i] = column[parents[which[i]]]
    where = Around(at[0], at[1], at[2], dispersal, spacing)
    free, out, left = np.zeros(n, np.bool_), np.zeros((n, 4), np.float32), n
    homeless = by_lot(key, names[0], APART) if spacing > 0 else np.arange(n)
    for attempt in range(TRIES):
        some = homeless[:left]
        draw_places(some, names[0], where, space, ground, key, attempt, out, free)
        crowded, taken = np.zeros(left, np.bool_), np.zeros(left, np.bool_)
        look(some, free, out, spacing, others, space, crowded, taken)
        left = keep_apart(some, spacing, space, crowded, taken, free, out)
        if left == 0:
            break
    for i in homeless[:left]:
        out[i, 3] = 0
    for i in range(n):
        if out[i, 3] > 0:
            litter, identity = which[i], names[0, i]
            which[m], names[0, m], names[1, m] = litter, identity, uid[litter]
            values[0, m], values[1, m], values[2, m] = out[i, 0], out[i, 1], out[i, 2]
            values[3, m] = draw(key, identity, random.SEX + (1 << 8)) * np.float32(6.2831855)
            values[4, m] = given[litter]
            born[litter] += 1
            m += 1
    return m


@njit
def look(homeless, free, places, spacing, others, space, crowded, taken):
    """Mark the positions of newborns i in `homeless` that are within `spacing` of a member of `table`, and
    those nearer than `apart` to the surface of a body in any table."""
    table, columns, high, apart = others
    for t in range(high.size):
        rows = high[t]
        alive = column_at(columns[t, 0], np.bool_, rows)
        x, y, z = (
            column_at(columns[t, 2], np.float32, rows),
            column_at(columns[t, 3], np.float32, rows),
            column_at(columns[t, 4], np.float32, rows),
        )
        close = spacing * spacing if t == table and spacing > 0 else np.float32(0.0)
        # a table without obstacles may have no radius
        radius = column_at(columns[t, 5 if apart[t] >= 0 else 2], np.float32, rows)
        for k in range(homeless.size):
            i = homeless[k]
            ax, ay, az, kin, body = places[i, 0], places[i, 1], places[i, 2], False, False
            for row in range(rows if free[i] else 0):  # branch-free, so that it vectorizes
                dx, dy, dz = offset(ax, ay, az, x[row], y[row], z[row], space)
                distance2, near = dx * dx + dy * dy + dz * dz, apart[t] + radius[row]
                kin |= alive[row] & (distance2 < close)
                body |= alive[row] & (distance2 < near * near)
            crowded[k] |= kin
            taken[k] |= body & (apart[t] >= 0)
