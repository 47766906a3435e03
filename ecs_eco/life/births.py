"""Births, for all reproduction systems: the number, positions and initial state of newborns."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import (
    Biology,
    Genome,
    Gestation,
    LifeHistory,
    Metabolism,
    Parentage,
    Policy,
    Position,
)
from ecs_eco.engine import random
from ecs_eco.engine.uids import matched
from ecs_eco.genomes.choices import CHOICES
from ecs_eco.life import sizes
from ecs_eco.life.broods import Brood, name, small_brood
from ecs_eco.life.founders import future, newcomers
from ecs_eco.life.places import Around, around, find_places
from ecs_eco.space.geometry import cell_of

if TYPE_CHECKING:
    from ecs_eco.config.models.reproduction import AnyBearing
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

LITTER_MAX = 65_535  # the largest number that a mother's column can store


class Lives(NamedTuple):
    """Life histories for kernels: each is a column, or the species' value as an array of length 1.

    If `own` is true, the value of a row is at [row], otherwise at [0].
    """

    own: bool
    age_min: np.ndarray
    energy_min: np.ndarray
    energy_given: np.ndarray
    litter: np.ndarray
    choice: np.ndarray


def life_history(table: Table, way: AnyBearing) -> Lives:
    """Return the life histories of a table that reproduces."""
    if LifeHistory in table:
        h = table[LifeHistory]
        return Lives(True, h.age_min, h.energy_min, h.energy_given, h.litter, h.choice)
    known = table.species.life_history
    if known is None or known[0] is not way:
        values = (
            np.array([v], np.float32) for v in (way.age_min, way.energy_min, way.energy_given, way.litter)
        )
        choice = np.array([CHOICES.index(getattr(way, "choice", "nearest"))], np.uint8)
        known = table.species.life_history = (way, Lives._make((False, *values, choice)))
    lives: Lives = known[1]
    return lives


class Wombs(NamedTuple):
    """Pregnancies for kernels: columns [rows]."""

    carrying: np.ndarray
    due: np.ndarray
    father: np.ndarray
    energy: np.ndarray
    rest: np.ndarray


def wombs_of(table: Table) -> Wombs:
    """Return the pregnancies of a table."""
    g = table[Gestation]
    return Wombs(g.carrying, g.due, g.father, g.energy, g.rest)


class Litters(NamedTuple):
    """The litters of a tick, ordered by the uids of the parents that bear them."""

    uid: np.ndarray  # u64[k]
    number: np.ndarray  # i64[k], newborn
    given: np.ndarray  # f32[k], energy for each newborn
    father: np.ndarray  # u64[k], dead or alive; 0 if there is none
    around: Around | None = None  # None: derived from the parents, all of which are in this process
    mine: Any = slice(None)  # litters whose parents are in this process, in its own order


def room(table: Table, world: SpatialWorld, wanted: int) -> int:
    """Return how many of the `wanted` newborns fit under `max_count`, and count those refused. Living
    organisms, pending births and the nursery occupy slots."""
    most, nursery, n = table.species.max_count, table.species.nursery, wanted
    if nursery is not None:
        n = room(nursery, world, n)
        most = None if most is None else most - nursery.n - nursery.waiting
    if most is not None:
        n = max(0, min(n, most - world.bands.count(table) - table.waiting))
    table.species.refused += wanted - n
    return n


def share_out(
    table: Table, world: SpatialWorld, uid: np.ndarray, number: np.ndarray, come: int, n: int
) -> tuple[np.ndarray, int]:
    """Return how many newborns of each litter, i64[k], and how many immigrants are allocated one of `n`
    slots. Each of the `number` i64[k] newborns of parents `uid` u64[k] and each of the `come` immigrants has
    the same probability of getting one."""
    uid = np.concatenate([uid, future(world, table, come)])
    number = np.concatenate([number, np.ones(come, np.int64)])
    wanted = int(number.sum())
    which, identity = np.empty(wanted, np.int64), np.empty(wanted, np.uint64)
    name(uid, number, which, identity)
    lucky = random.by_lot(world.key, identity, random.LOT)[:n]
    got = np.bincount(which[lucky], minlength=uid.size)
    return got[: uid.size - come], int(got[uid.size - come :].sum())


def bring_forth(
    table: Table,
    world: SpatialWorld,
    way: AnyBearing,
    parents: np.ndarray,
    number: np.ndarray,
    given: np.ndarray,
    fathers: np.ndarray | None = None,
    sperm: np.ndarray | None = None,
) -> np.ndarray:
    """Request `number` i64[k] newborns of each parent (rows i64[k], in uid order); return how many fit.

    Each newborn gets the energy `given` f32[k]; the caller deducts it from the parent. `fathers` are uids
    u64[k], dead or alive, and `sperm` u8[k, loci] contains their genomes. Immigrants compete with newborns
    for the slots still available under `max_count`.
    """
    alone = not world.bands.divided
    litters = (
        None
        if alone
        else world.bands.litters(
            litters_of(table, parents, number, given, fathers), around(table, way, parents)
        )
    )
    asked = number if litters is None else litters.number
    come = immigrants(table, world, way.immigration) if way.kind != "sexual" and way.immigration else 0
    wanted = sum(asked.tolist()) + come
    n, born = room(table, world, wanted), None
    if n < wanted:
        uid = table.uid[parents] if litters is None else litters.uid
        asked, come = share_out(table, world, uid, asked, come, n)
        number, litters = (asked, None) if litters is None else (number, litters._replace(number=asked))
    if n > come:
        found = small_brood(table, world, way, parents, number, given, n - come) if alone else None
        if found is None:
            litters = litters or litters_of(table, parents, number, given, fathers)
            found = any_brood(table, world, way, parents, litters, n - come)
        brood, born = found
        if brood.which.size:
            if fathers is not None:
                fathers = (fathers if litters is None else litters.father)[brood.which]
            request(table, world, parents, litters, brood, fathers, sperm)
    if come:
        table.request(
            np.zeros(come, np.uint64),
            newcomers(table, world, table.species.section, future(world, table, come)),
        )
    return np.zeros(parents.size, np.int64) if born is None else born


def immigrants(table: Table, world: SpatialWorld, rate: float) -> int:
    """Return how many immigrants arrive in this tick: the integer part of rate × dt, plus one with the
    probability of the fractional part."""
    return int(
        rate * world.dt + float(random.draw(world.key, np.uint64(table.place), random.BIRTH + (2 << 8)))
    )


def litters_of(
    table: Table, parents: np.ndarray, number: np.ndarray, given: np.ndarray, fathers: np.ndarray | None
) -> Litters:
    """Return the litters of parents in rows i64[k], given the arguments of `bring_forth`."""
    father = np.zeros(parents.size, np.uint64) if fathers is None else fathers
    return Litters(table.uid[parents], number, given, father)


def any_brood(
    table: Table, world: SpatialWorld, way: AnyBearing, parents: np.ndarray, litters: Litters, n: int
) -> tuple[Brood, np.ndarray]:
    """Return the newborns, of `n`, for which a position was found, and each parent's number of newborns
    i64[k]."""
    which, identity = np.empty(n, np.int64), np.empty(n, np.uint64)
    name(litters.uid, litters.number, which, identity)
    where = around(table, way, parents[which]) if litters.around is None else litters.around.of(which)
    places = find_places(table, world, where, identity)
    placed = places[:, 3] > 0
    if not np.logical_and.reduce(placed):
        which, identity, places = which[placed], identity[placed], places[placed]
    brood = Brood(
        which,
        identity,
        litters.uid[which],
        places[:, 0],
        places[:, 1],
        places[:, 2],
        headings(world, identity),
        litters.given[which],
    )
    return brood, np.bincount(which, minlength=litters.uid.size)[litters.mine]


def request(
    table: Table,
    world: SpatialWorld,
    parents: np.ndarray,
    litters: Litters | None,
    brood: Brood,
    second: np.ndarray | None,
    sperm: np.ndarray | None,
) -> None:
    """Request newborns whose positions have been found, in the table's nursery if it has one. `litters` are
    the litters of all processes if there are several; `second` u64[n] contains the newborns' fathers, and
    `sperm` u8[k, loci] the genomes of the litters' fathers."""
    nursery, which, identity = table.species.nursery, brood.which, brood.identity
    into = table if nursery is None else nursery  # not `or`, because an empty table is false
    values = newborn(into, world, identity, *brood[3:])
    if table.species.heredity is not None:
        inherits = inherited if world.bands.inherited is None else world.bands.inherited
        values |= inherits(world, table, parents, litters, which, identity, brood.y, second, sperm)
    if into is table:
        if table.species.standard_mass is not None:
            values |= sizes.of_newborn(table, values, which.size)
    else:  # traits are expressed when newborns leave the nursery
        values = {key: v for key, v in values.items() if key[0] in (Position, Metabolism, Genome, Policy)}
    if Parentage in into:
        values[Parentage, "mother"] = brood.mother
        values[Parentage, "father"] = np.zeros(which.size, np.uint64) if second is None else second
    into.request(brood.mother, values, second)


def inherited(
    world: SpatialWorld,
    table: Table,
    parents: np.ndarray,
    litters: Any,
    which: np.ndarray,
    identity: np.ndarray,
    y: np.ndarray,
    second: np.ndarray | None,
    sperm: np.ndarray | None,
) -> dict[tuple[type, str], np.ndarray]:
    """Return the inherited columns of newborns in litters `which` i64[n] of parents in rows `parents`."""
    living = None if second is None else rows_of(table, second)
    more = {} if sperm is None else {"sperm": sperm[which]}
    return table.species.heredity.offspring(world, table, parents[which], living, identity, **more)


def newborn(
    table: Table,
    world: SpatialWorld,
    identity: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    z: np.ndarray,
    heading: np.ndarray,
    energy: np.ndarray,
) -> dict[tuple[type, str], np.ndarray]:
    """Return the columns whose values in newborns differ from the table's defaults: position, heading, sex,
    energy.

    `identity` u64[k] identifies each newborn's random draws.
    """
    values: dict[tuple[type, str], np.ndarray] = {
        (Position, "x"): x,
        (Position, "y"): y,
        (Position, "z"): z,
        (Position, "heading"): heading,
        (Metabolism, "energy"): energy,
    }
    if table.species.sex == "random":
        values[Biology, "sex"] = np.where(
            random.draw_many(world.key, identity, random.SEX) < 0.5, 1, 2
        ).astype(np.uint8)
    return values


def headings(world: SpatialWorld, identity: np.ndarray) -> np.ndarray:
    """Return random headings for newborns, drawn for `identity` u64[k]: f32[k]."""
    turn = random.draw_many(world.key, identity, random.SEX + (1 << 8))
    return turn * np.float32(6.2831855)


def rows_of(table: Table, uids: np.ndarray) -> np.ndarray:
    """Return the rows i64[k] of living organisms with these uids; −1 for dead ones."""
    rows = table.by_uid()
    at, there = matched(table.uid[rows], uids)
    out = np.full(uids.size, -1)
    out[there] = rows[at[there]]
    return out


def ticks(seconds: Any, dt: float) -> Any:
    """Return the smallest number of ticks that last at least `seconds`, except for the rounding of float32: a
    number, or i64 per row."""
    if isinstance(seconds, np.ndarray):
        return np.ceil(seconds.astype(np.float64) / dt * (1 - 1e-6)).astype(np.int64)
    return math.ceil(seconds / dt * (1 - 1e-6))


@njit
def whole(litter):
    """Return a litter's size rounded to an integer, at most LITTER_MAX."""
    return cell_of(litter + np.float32(0.5), LITTER_MAX + 1)


@njit
def affordable(energy, given, n):
    """Return how many newborns, at most n, a parent can pay for at `given` each without its energy falling to
    0; n if they cost nothing."""
    while n > 0 and given > 0 and not energy - np.float32(n) * given > 0:
        n -= 1
    return n
