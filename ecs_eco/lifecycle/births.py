"""Births, as all systems of reproduction need them: number, place and initial state of the newborn."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import (
    Biology,
    Body,
    Genome,
    LifeHistory,
    Metabolism,
    Parentage,
    Policy,
    Position,
    Shape,
)
from ecs_eco.engine import random
from ecs_eco.engine.jit import njit
from ecs_eco.engine.per_row import of_row
from ecs_eco.engine.random import draw, mix
from ecs_eco.genomes.choices import CHOICES
from ecs_eco.genomes.own_values import own_values
from ecs_eco.lifecycle import sizes
from ecs_eco.space.barriers import POINT
from ecs_eco.space.bodies import rocks, solids
from ecs_eco.space.geometry import cell_of, into
from ecs_eco.space.shapes import touching
from ecs_eco.space.sight import gather, offset
from ecs_eco.space.solids import around
from ecs_eco.space.terrain import ROCK, WATER, ground_at

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

LITTER_MAX = 65_535  # the largest number that a mother's column holds
TRIES = 8  # places tried before a birth fails for lack of room


def life_history(table: Table, way: Any) -> tuple[Any, ...]:
    """Return (own, age_min, energy_min, energy_given, litter, choice): each a column,
    or the species' value as an array of one.

    `own` says which: the value of a row is at [row] where it is true, at [0] where it is not.
    """
    if LifeHistory in table:
        h = table[LifeHistory]
        return True, h.age_min, h.energy_min, h.energy_given, h.litter, h.choice
    known = table.species.life_history
    if known is None or known[0] is not way:
        values = (np.array([v], np.float32)
                  for v in (way.age_min, way.energy_min, way.energy_given, way.litter))
        choice = np.array([CHOICES.index(getattr(way, "choice", "nearest"))], np.uint8)
        known = table.species.life_history = (way, (False, *values, choice))
    return known[1]


def room(table: Table, wanted: int) -> int:
    """Return how many of `wanted` newborn there is room for:
    `max_count` minus the living, the births pending, and the eggs."""
    most, eggs = table.species.max_count, table.species.eggs
    if eggs is not None:
        wanted = room(eggs, wanted)
        most = None if most is None else most - eggs.n - eggs.waiting
    return wanted if most is None else max(0, min(wanted, most - table.n - table.waiting))


def bring_forth(table: Table, world: SpatialWorld, way: Any, parents: np.ndarray, number: np.ndarray,
                given: np.ndarray,
                fathers: np.ndarray | None = None, sperm: np.ndarray | None = None) -> np.ndarray:
    """Request `number` i64[k] newborn of each parent (rows i64[k] in the order of uids);
    return how many there was room for.
    A species that lays eggs has them laid.

    Each newborn gets the energy `given` f32[k]; the caller takes it from the parent. `fathers` are uids
    u64[k], dead or alive, `sperm` u8[k, loci] their genomes.
    """
    wanted = int(np.add.reduce(number))
    n = room(table, wanted)
    which = np.arange(parents.size).repeat(number)[:n]
    nth = (np.arange(wanted) - (number.cumsum() - number).repeat(number))[:n]
    if not which.size:
        return np.zeros(parents.size, np.int64)
    mothers = parents[which]
    identity = np.empty(which.size, np.uint64)
    name(table.uid[mothers], nth, identity)
    places = find_places(table, world, mothers, identity, way)
    placed = places[:, 3] > 0
    if not np.logical_and.reduce(placed):
        which, mothers, identity, places = which[placed], mothers[placed], identity[placed], places[placed]
    if which.size:
        nest, second = table.species.eggs, None if fathers is None else fathers[which]
        values = newborn(table if nest is None else nest, world, places, identity, given[which])
        if (heredity := table.species.heredity) is not None:
            living = None if second is None else rows_of(table, second)
            values |= heredity.offspring(world, table, mothers, living, identity,
                                         **({} if sperm is None else {"sperm": sperm[which]}))
        if nest is None:
            nest = table
            values |= sizes.of_newborn(table, values, which.size)
        else:  # traits are expressed when it hatches
            values = {key: v for key, v in values.items() if key[0] in (Position, Metabolism, Genome, Policy)}
        if Parentage in nest:
            values[Parentage, "mother"] = table.uid[mothers]
            values[Parentage, "father"] = np.zeros(which.size, np.uint64) if second is None else second
        nest.request(table.uid[mothers], values, second)
    return np.bincount(which, minlength=parents.size)


def newborn(table: Table, world: SpatialWorld, places: np.ndarray, identity: np.ndarray,
            energy: np.ndarray) -> dict[tuple[type, str], np.ndarray]:
    """Return the columns in which newborn differ from the table's defaults: place, heading, sex, energy.

    `identity` u64[k] identifies each one's random draws.
    """
    turn = random.draw_many(world.key, identity, random.SEX + (1 << 8))
    values: dict[tuple[type, str], np.ndarray] = {(Position, axis): places[:, i]
                                                  for i, axis in enumerate("xyz")}
    values |= {(Position, "heading"): turn * np.float32(6.2831855), (Metabolism, "energy"): energy}
    if table.species.sex == "random":
        values[Biology, "sex"] = np.where(random.draw_many(world.key, identity, random.SEX) < 0.5, 1,
                                          2).astype(np.uint8)
    return values


def rows_of(table: Table, uids: np.ndarray) -> np.ndarray:
    """Return the rows of the living with these uids: i64[k], −1 for the dead."""
    rows = table.by_uid()
    known = table.uid[rows]
    at = np.minimum(np.searchsorted(known, uids), max(known.size - 1, 0))
    return np.where(known[at] == uids, rows[at], -1)


def find_places(table: Table, world: SpatialWorld, parents: np.ndarray,
                identity: np.ndarray, way: Any) -> np.ndarray:
    """Return (x, y, z, whether there is room) for each newborn of `parents` i64[k],
    drawn for `identity` u64[k]: f32[k, 4]."""
    space, p, own = world.space, table[Position], world.index(table)
    out = np.zeros((parents.size, 4), np.float32)
    radius = float(table.defaults[Body]["radius"]) * bound_of(table)
    ground, inverse = rocks(world)
    near = np.float32(-1.0 if way.place == "anywhere" else way.dispersal or 4 * radius)
    spacing, widest = np.float32(way.spacing), way.spacing
    if table.species.traits:
        spacing, near = own_values(table, {"reproduction.spacing": spacing, "reproduction.dispersal": near})
    if isinstance(spacing, np.ndarray):
        spacing, near = spacing[parents], near[parents]
        widest = float(spacing.max())
    widest, x, y, z = max(widest, 1e-3), p.x[parents], p.y[parents], p.z[parents]
    homeless = np.arange(parents.size)
    for attempt in range(TRIES):
        if attempt:
            out[homeless, 3] = 0
        _place(homeless, identity, x, y, z, near, spacing,
               own.x, own.y, own.z, own.start,
               space.reach(widest), *space.shape, space.inverse, space.lengths, space.torus,
               space.volume, ground, inverse, world.key, attempt, out)
        taken = np.zeros(parents.size, np.bool_)
        for other in world.tables.values():
            if other.n and other.species.opaque and Body in other.columns:
                if Shape in other.columns:
                    bodies = solids(world, [other.name])
                    _occupied_by_solids(out, bodies.form, *space.shape, space.inverse, space.lengths,
                                        space.torus, space.volume, *bodies.cells, np.float32(radius), POINT,
                                        taken)
                    continue
                index = own if other is table else world.index(other)
                s = np.float32(radius + other.species.radius)
                _occupied(out, index.x, index.y, index.z, index.start, s, space.reach(float(s)), *space.shape,
                          space.inverse, space.lengths, space.torus, taken)
        (homeless,) = taken.nonzero()
        if not homeless.size:
            return out
    out[homeless, 3] = 0
    return out


def bound_of(table: Table) -> float:
    """Return the radius of the smallest sphere around a newborn, in radii of its body."""
    if Shape not in table:
        return 1.0
    form = {field: float(value) for field, value in table.defaults[Shape].items()}
    return form.pop("rounding") + math.hypot(*form.values())


@njit
def name(uid, nth, identity):
    """Write the identity of each newborn of a tick: its parent's uid for the first of a litter,
    a hash of it for the others."""
    for i in range(uid.size):
        identity[i] = uid[i] if nth[i] == 0 else mix(mix(uid[i]) + np.uint64(nth[i]))


def ticks(seconds: Any, dt: float) -> Any:
    """Return the least number of ticks that last at least `seconds`: a number, or one for each row i64."""
    if isinstance(seconds, np.ndarray):
        return np.ceil(seconds / dt - 1e-6).astype(np.int64)
    return math.ceil(seconds / dt - 1e-6)


@njit
def whole(litter):
    """Return a litter's size rounded to a whole number, at most LITTER_MAX."""
    return cell_of(litter + np.float32(0.5), LITTER_MAX + 1)


@njit
def affordable(energy, given, n):
    """Return how many newborn, at most n, a parent can pay `given` for without falling to 0."""
    while n > 0 and not energy - np.float32(n) * given > 0:
        n -= 1
    return n


@njit
def _place(homeless, identity, px, py, pz, dispersal, spacing, ox, oy, oz, start, reach, nx, ny, nz, inverse,
           lengths, torus, volume, ground, ground_inverse, key, attempt, out):
    """Draw a place for each newborn i of `homeless`; out[i, 3] is 1 where neither rock nor one of its kind
    within `spacing` forbids it."""
    near = np.empty(ox.size, np.int64)
    salt = attempt << 10
    for i in homeless:
        u, v, w = (draw(key, identity[i], random.PLACE + salt),
                   draw(key, identity[i], random.PLACE + (1 << 8) + salt),
                   draw(key, identity[i], random.PLACE + (2 << 8) + salt))
        furthest, apart = of_row(dispersal, i), of_row(spacing, i)
        if furthest < 0:
            x, y, z = u * lengths[0], v * lengths[1], w * lengths[2]
        else:
            r, a = furthest * np.sqrt(u), np.float32(6.2831855) * v
            x, y = (into(px[i] + r * np.cos(a), lengths[0], torus),
                    into(py[i] + r * np.sin(a), lengths[1], torus))
            z = (into(pz[i] + furthest * (np.float32(2) * w - np.float32(1)), lengths[2], False)
                 if volume else pz[i])
        free = True
        if ground.size > 1:  # fences leave a place free
            kind = ground_at(ground, ground_inverse, x, y)
            free = kind not in (WATER, ROCK)
        if free and apart > 0:
            n = gather(x, y, z, reach, start, ox, oy, oz, nx, ny, nz, inverse, lengths, torus, near)
            for q in range(n):
                dx, dy, dz = offset(x, y, z, ox[near[q]], oy[near[q]], oz[near[q]], lengths, torus)
                if dx * dx + dy * dy + dz * dz < apart * apart:
                    free = False
                    break
            for j in range(identity.size):  # and others of this tick that already have a place
                dx, dy, dz = offset(x, y, z, out[j, 0], out[j, 1], out[j, 2], lengths, torus)
                if out[j, 3] > 0 and dx * dx + dy * dy + dz * dz < apart * apart:
                    free = False
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = x, y, z, 1 if free else 0


@njit
def _occupied(places, ox, oy, oz, start, s, reach, nx, ny, nz, inverse, lengths, torus, taken):
    near = np.empty(ox.size, np.int64)
    for i in range(taken.size):
        if places[i, 3] == 0 or taken[i]:
            continue
        x, y, z = places[i, 0], places[i, 1], places[i, 2]
        n = gather(x, y, z, reach, start, ox, oy, oz, nx, ny, nz, inverse, lengths, torus, near)
        for q in range(n):
            dx, dy, dz = offset(x, y, z, ox[near[q]], oy[near[q]], oz[near[q]], lengths, torus)
            if dx * dx + dy * dy + dz * dz < s * s:
                taken[i] = True
                break


@njit
def _occupied_by_solids(places, form, nx, ny, nz, inverse, lengths, torus, volume, start, entry, radius,
                        point, taken):
    """`_occupied` for capsules and boxes, whose surfaces are no nearer than `radius` [m] to a free place."""
    near, seen = np.empty(len(form), np.int64), np.zeros(len(form) + 1, np.int64)
    r = np.float64(radius)
    for i in range(taken.size):
        if places[i, 3] == 0 or taken[i]:
            continue
        x, y, z = np.float64(places[i, 0]), np.float64(places[i, 1]), np.float64(places[i, 2])
        n = around(x, y, z, r, r, r, nx, ny, nz, inverse, lengths, torus, start, entry, seen, near)
        for q in range(n):
            e = near[q]
            gap, _, _, _ = touching(point, 0, form, e, x - form[e, 0], y - form[e, 1], z - form[e, 2],
                                    lengths, torus, volume)
            if gap < r:
                taken[i] = True
                break
