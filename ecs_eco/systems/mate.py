"""Two organisms meet and mate."""

from __future__ import annotations

import random as pyrandom
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.compiled.elementary import power
from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Biology, Body, Genome, Gestation, Metabolism, Nervous, Position, Shape
from ecs_eco.components.reproduction import FEMALE, MALE
from ecs_eco.engine import random
from ecs_eco.engine.random import bits, draw, mix
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import highest, own_value, own_values
from ecs_eco.life.births import Lives, Wombs, life_history, rows_of, ticks, whole, wombs_of
from ecs_eco.life.torpor import awake
from ecs_eco.space.bodies import bound, solids
from ecs_eco.space.geometry import Extent
from ecs_eco.space.index import Entries, Index
from ecs_eco.space.shapes import touching
from ecs_eco.space.sight import gather, offset

if TYPE_CHECKING:
    from ecs_eco.config.models.reproduction import Sexual
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

CHOOSES, SIRES = 1, 2  # bits for the roles of a ready organism
MEET, TASTE, TIE = random.MATE, random.MATE + (1 << 8), random.MATE + (2 << 8)  # purposes of random draws
NO_DECISION = np.zeros((1, 1), np.uint8)
SPHERES = np.zeros((0, 9), np.float32)  # empty `form`: all bodies are spheres
WILLING = {"none": 0, "one": 1, "both": 2}


class Wishes(NamedTuple):
    """Willingness to mate, for kernels."""

    column: int  # column of the `mate` action; −1: none
    decision: np.ndarray  # u8[rows, actions]
    consent: int  # number of partners that must be willing


class Sires(NamedTuple):
    """Possible sires, for kernels; `form` f32[k, 9] is empty if all bodies are spheres."""

    can: np.ndarray  # u8[rows], roles
    radius: np.ndarray  # f32[rows] [m]
    energy: np.ndarray  # f32[rows]
    reach: Number  # [m]
    share: Number  # father's share of a litter's energy
    form: np.ndarray


class Mate(System):
    """Each female (without sexes: each member) that is ready and willing chooses one ready and willing mate
    within reach, and may conceive.

    An organism is ready if it is old enough, well fed, rested and not pregnant; a male must also be able to
    pay his share, and pays it at conception. In a species without sexes, any two members can mate, and the
    chooser bears the young. No organism mates twice in a tick; nearer pairs have precedence, and ties are
    broken at random. The probability of conception is `chance` per second of contact, multiplied by the
    fertility of both partners.
    """

    needs = (Position, Body, Metabolism, Biology, Gestation)
    phase = "interact"
    divisible = True
    submodel = Submodel(
        "Sexual reproduction",
        where=("reproduction.kind=sexual",),
        reads=("reproduction",),
        rules={
            "sex=none": "The species has no sexes: any two members may mate, and the chooser bears the "
            "young.",
            "": "A pair conceives in a tick with probability `1 − (1 − chance × fertility_mother × "
            "fertility_father)^dt`; nearer pairs come first, and no organism mates twice in a tick. A parent "
            "must be at least `age_min` old, hold at least `energy_min`, be rested and not be pregnant. Birth "
            "follows after `gestation`, by default in the same tick. Each newborn gets `energy_given`, of which "
            "the father pays `father_share` and the mother the rest.",
        },
        changes=("Gestation", "Metabolism.energy", "Metabolism.given"),
        draws="whether a pair conceives, and the order of equally near pairs",
    )

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Mate members of one species."""
        way = table.species.reproduction
        if way is None or way.kind != "sexual" or not world.reproduction:
            return
        b, m = table[Biology], table[Metabolism]
        lives, can = life_history(table, way), np.empty(table.high, np.uint8)
        wishes = Wishes(*action(table), WILLING[way.consent])
        n_chooses, n_sires = ready(
            awake(table)[: table.high],
            table.cause,
            b.sex,
            b.age,
            m.energy,
            wombs_of(table),
            world.tick,
            lives,
            wishes,
            can,
        )
        if (n_chooses == 0 or n_sires == 0) and not world.bands.divided:
            return
        i, space, radius = world.index(table), world.space, table[Body].radius
        rule = select_mate(table)
        if rule is not None and not lives.own:
            lives = lives._replace(choice=np.array([max(rule[0], 0)], np.uint8))
        reach, share = own_values(
            table,
            {
                "reproduction.reach": np.float32(way.reach),
                "reproduction.father_share": np.float32(way.father_share),
            },
        )
        furthest = highest(reach, table.alive) if isinstance(reach, np.ndarray) else way.reach
        form = solids(world, [table.name]).form if Shape in table else SPHERES
        largest = highest(radius, table.alive) if form is SPHERES else bound(table)
        widest = 2 * largest + furthest
        partner, distance2 = np.empty(i.n, np.int64), np.empty(i.n, np.float32)
        sires, cells = Sires(can, radius, m.energy, reach, share, form), space.reach(widest)
        with world.bands.own(i, partner, distance2):
            world.split(
                propose,
                i.n,
                i.entries,
                sires,
                wishes,
                lives,
                b.age,
                cells,
                space.extent,
                world.key,
                partner,
                distance2,
            )
        if world.bands.divided:
            self.conceive(table, world, way, agreed(table, world, i, partner, distance2))
            return
        choosers = np.flatnonzero(partner >= 0)
        if choosers.size == 0:
            return
        if rule is not None and rule[0] < 0 and not lives.own:
            suits = sires, wishes, lives, cells, space.extent
            self.ask(table, rule[1], i, choosers, suits, partner, distance2, world)
        order = choosers[nearest_first(world.key, i.uid[choosers], distance2[choosers])]
        pairs = np.empty((order.size, 2), np.int64)
        n = pair(order, partner, i.rows, np.zeros(i.n, np.bool_), pairs)
        self.conceive(table, world, way, pairs[:n])

    def ask(
        self,
        table: Table,
        rule: Any,
        i: Index,
        choosers: np.ndarray,
        suits: tuple[Any, ...],
        partner: np.ndarray,
        distance2: np.ndarray,
        world: SpatialWorld,
    ) -> None:
        """Choose mates with a user-defined function, one chooser at a time, in uid order."""
        chosen, far = np.empty(i.n, np.int64), np.empty(i.n, np.float32)
        energy, age = table[Metabolism].energy, table[Biology].age
        state = pyrandom.getstate()
        try:
            for me in choosers[np.argsort(i.uid[choosers])]:
                n = suitors(me, i.entries, *suits, chosen, far)
                rows, uids = i.rows[chosen[:n]], i.uid[chosen[:n]].tolist()
                pyrandom.seed(int(world.key) ^ int(i.uid[me]))
                it = rule(
                    int(i.uid[me]), uids, np.sqrt(far[:n]).tolist(), energy[rows].tolist(), age[rows].tolist()
                )
                if it not in uids:
                    raise ValueError(
                        f"select_mate of {table.name!r} returns {it!r} for {int(i.uid[me])}; "
                        f"expected one of {uids[:9]}"
                    )
                partner[me], distance2[me] = chosen[uids.index(it)], far[uids.index(it)]
        finally:
            pyrandom.setstate(state)

    def conceive(self, table: Table, world: SpatialWorld, way: Sexual, pairs: np.ndarray) -> None:
        """Draw which `pairs` (rows of mother and father, i64[n, 2]) conceive, and update the parents."""
        b, m, g = table[Biology], table[Metabolism], table[Gestation]
        chance, (she, he) = own_value(table, "reproduction.chance", way.chance), pairs.T
        each = chance[she] if isinstance(chance, np.ndarray) else chance
        fail = 1 - each * b.fertility[she].astype(float) * b.fertility[he]
        success = 1 - power(np.maximum(fail, 0.0), world.dt)
        share, gestation, rest = own_values(
            table,
            {
                "reproduction.father_share": np.float32(way.father_share),
                "reproduction.gestation": way.gestation,
                "reproduction.father_rest": way.father_rest,
            },
        )
        conceived = np.zeros(len(pairs), np.bool_)
        join(
            pairs,
            table.uid,
            life_history(table, way),
            share,
            success,
            world.key,
            world.tick + ticks(gestation, world.dt),
            world.tick + ticks(rest, world.dt),
            conceived,
            m.energy,
            m.given,
            wombs_of(table),
        )
        if Genome in table:
            mothers, fathers = pairs[conceived].T
            g.sperm[mothers] = table[Genome].loci[fathers]


def agreed(
    table: Table, world: SpatialWorld, i: Index, partner: np.ndarray, distance2: np.ndarray
) -> np.ndarray:
    """Return the pairs that mate when each process knows only its own organisms' choices: rows i64[n, 2] of
    the pairs in this process, ghosts included."""
    here = world.bands.entries(i)
    mine = here.start + np.flatnonzero(partner[here] >= 0)
    uid, chosen, far = world.bands.everyone(i.uid[mine], i.uid[partner[mine]], distance2[mine])
    who, entry = np.unique(np.concatenate([uid, chosen]), return_inverse=True)
    choosers, of = entry[: uid.size], np.full(who.size, -1)
    of[choosers] = entry[uid.size :]
    pairs = np.empty((uid.size, 2), np.int64)
    n = pair(
        choosers[nearest_first(world.key, uid, far)],
        of,
        np.arange(who.size),
        np.zeros(who.size, np.bool_),
        pairs,
    )
    rows = rows_of(table, who)[pairs[:n]] if n else pairs[:0]
    return np.ascontiguousarray(rows[(rows >= 0).all(axis=1)])


def nearest_first(key: np.uint64, uid: np.ndarray, distance2: np.ndarray) -> np.ndarray:
    """Return the order of choosers u64[n] by distance, with ties broken at random: i64[n]."""
    order = random.by_lot(key, uid, TIE)
    return order[distance2[order].argsort(kind="stable")]


def action(table: Table) -> tuple[int, np.ndarray]:
    """Return the column of the `mate` action in the decision (−1: no such action), and the decision."""
    nerves = table.species.nerves
    column = (
        -1
        if nerves is None
        else next((i for i, (group, _) in enumerate(nerves.actions) if group == "mate"), -1)
    )
    return column, table[Nervous].decision if column >= 0 else NO_DECISION


def select_mate(table: Table) -> tuple[int, Any] | None:
    """Return the mating rule in the species' toolbox: its number (−1: user-defined) and its function; None
    without a toolbox."""
    operators = getattr(table.species.heredity, "operators", None)
    return None if operators is None else (operators.choice, operators.toolbox.select_mate)


@njit
def wills(wishes, row):
    """Return 1 if an organism wants to mate, otherwise 0."""
    return 1 if wishes.column < 0 or wishes.decision[row, wishes.column] else 0


@njit
def ready(
    alive: np.ndarray,
    cause: np.ndarray,
    sex: np.ndarray,
    age: np.ndarray,
    energy: np.ndarray,
    wombs: Wombs,
    tick: int,
    lives: Lives,
    wishes: Wishes,
    can: np.ndarray,
) -> tuple[int, int]:
    """Write each row's roles to `can` u8[rows]; return how many organisms can choose and how many can sire."""
    n_chooses, n_sires, carrying, rest = 0, 0, wombs.carrying, wombs.rest
    own, age_min, energy_min, litter = lives.own, lives.age_min, lives.energy_min, lives.litter
    for row in range(can.size):
        i = row if own else 0
        can[row] = 0
        if (
            not alive[row]
            or cause[row]
            or carrying[row]
            or rest[row] > tick
            or age[row] < age_min[i]
            or energy[row] < energy_min[i]
        ):
            continue
        if wishes.consent == 2 and not wills(wishes, row):
            continue
        if sex[row] != MALE and litter[i] >= np.float32(0.5):
            can[row] |= CHOOSES
            n_chooses += 1
        if sex[row] != FEMALE:
            can[row] |= SIRES
            n_sires += 1
    return n_chooses, n_sires


@njit
def suits(i, j, mine, sires, wishes, want, each, number, space):
    """Return the squared distance from entry i to entry j if j can sire, can pay, is willing and is within
    reach, otherwise −1. If some bodies are not spheres, it is the distance between surfaces."""
    rows, x, y, z, _, _ = mine
    can, radius, energy, near, share, form = sires
    it = rows[j]
    price = of_row(share, it) * each * number
    if j == i or not can[it] & SIRES or (price > 0 and not energy[it] > price) or wills(wishes, it) < want:
        return np.float32(-1)
    if len(form):
        dx, dy, dz = np.float64(x[i] - x[j]), np.float64(y[i] - y[j]), np.float64(z[i] - z[j])
        gap, _, _, _ = touching(form, i, form, j, dx, dy, dz, space)
        return np.float32(max(gap, 0.0) ** 2) if gap <= of_row(near, rows[i]) else np.float32(-1)
    ax, ay, az = offset(x[i], y[i], z[i], x[j], y[j], z[j], space)
    d2, s = ax * ax + ay * ay + az * az, radius[rows[i]] + radius[it] + of_row(near, rows[i])
    return d2 if d2 <= s * s else np.float32(-1)


@njit
def suitors(
    i: int,
    mine: Entries,
    sires: Sires,
    wishes: Wishes,
    lives: Lives,
    reach: int,
    space: Extent,
    chosen: np.ndarray,
    far: np.ndarray,
) -> int:
    """List the possible sires for entry i and their squared distances; return their number."""
    rows, x, y, z, _, _ = mine
    close, n = np.empty(x.size, np.int64), 0
    each, number = lives.energy_given[0], np.float32(whole(lives.litter[0]))
    want = wishes.consent - wills(wishes, rows[i])
    for c in range(gather(x[i], y[i], z[i], reach, mine, space, close)):
        d2 = suits(i, close[c], mine, sires, wishes, want, each, number, space)
        if d2 >= 0:
            chosen[n], far[n] = close[c], d2
            n += 1
    return n


@njit
def propose(
    first: int,
    last: int,
    mine: Entries,
    sires: Sires,
    wishes: Wishes,
    lives: Lives,
    age: np.ndarray,
    reach: int,
    space: Extent,
    key: np.uint64,
    partner: np.ndarray,
    distance2: np.ndarray,
) -> None:
    """Write the father that each of the index entries first … last − 1 chooses (−1: none), and his squared
    distance.

    The chosen father is the nearest, a random one, the richest or the oldest; ties are broken by distance,
    then at random.
    """
    rows, x, y, z, uid, _ = mine
    own, _, _, energy_given, litter, choice = lives
    can, energy = sires.can, sires.energy
    close = np.empty(x.size, np.int64)
    for i in range(first, last):
        me, partner[i], distance2[i] = rows[i], -1, np.inf
        if not can[me] & CHOOSES:
            continue
        life, best = me if own else 0, np.float32(np.inf)
        each, number = energy_given[life], np.float32(whole(litter[life]))
        want = wishes.consent - wills(wishes, me)
        n = gather(x[i], y[i], z[i], reach, mine, space, close)
        for c in range(n):
            j = close[c]
            it = rows[j]
            d2 = suits(i, j, mine, sires, wishes, want, each, number, space)
            if d2 < 0:
                continue
            score = d2
            if choice[life] == 1:
                score = draw(key, mix(uid[i]) ^ uid[j], TASTE)
            elif choice[life] == 2:
                score = -energy[it]
            elif choice[life] == 3:
                score = -age[it]
            k = partner[i]
            if (
                k < 0
                or score < best
                or (
                    score == best
                    and (
                        d2 < distance2[i]
                        or (
                            d2 == distance2[i]
                            and bits(key, mix(uid[i]) ^ uid[j], TIE) < bits(key, mix(uid[i]) ^ uid[k], TIE)
                        )
                    )
                )
            ):
                best, partner[i], distance2[i] = score, j, d2


@njit
def pair(order, partner, rows, taken, pairs):
    """List the pairs that mate, as rows of the chooser and the chosen; `order` lists the choosers by
    precedence."""
    n = 0
    for i in order:
        j = partner[i]
        if not taken[i] and not taken[j]:
            taken[i] = taken[j] = True
            pairs[n, 0], pairs[n, 1] = rows[i], rows[j]
            n += 1
    return n


@njit
def join(
    pairs: np.ndarray,
    uid: np.ndarray,
    lives: Lives,
    share: Number,
    success: np.ndarray,
    key: np.uint64,
    due: Number,
    rested: Number,
    conceived: np.ndarray,
    energy: np.ndarray,
    given: np.ndarray,
    wombs: Wombs,
) -> None:
    """Draw whether each pair conceives; if it does, the mother becomes pregnant, and the father pays his
    share and rests."""
    own, _, _, energy_given, litter, _ = lives
    carrying, due_at, father, stored, rest = wombs
    for p in range(len(pairs)):
        she, he = pairs[p, 0], pairs[p, 1]
        if draw(key, uid[she], MEET) >= success[p]:
            continue
        life = she if own else 0
        number = whole(litter[life])
        before = energy[he]
        energy[he] = before - of_row(share, he) * energy_given[life] * np.float32(number)
        given[he] += before - energy[he]
        stored[she] = before - energy[he]
        carrying[she], due_at[she], father[she], conceived[p] = (number, of_row(due, she), uid[he], True)
        rest[he] = of_row(rested, he)
