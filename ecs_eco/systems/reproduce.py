"""Animals reproduce without mates (the paper's simplified reproduction, and division)."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.compiled.elementary import arrays
from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Biology, Body, Metabolism, Position
from ecs_eco.engine import random
from ecs_eco.engine.random import draw
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_value
from ecs_eco.life.births import LITTER_MAX, Lives, affordable, bring_forth, life_history, whole

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Reproduce(System):
    """A parent that is well fed and old enough gives birth at a given rate and pays the newborn's energy; it
    gives birth several times in a tick if it stays well fed.

    The newborn appears at a random unoccupied position (`anywhere`, or within `dispersal` of the parent). If
    another member of its species lives within `spacing`, the birth fails and costs nothing. A litter is
    limited to the number of newborns that the parent can pay for without its energy falling to 0. Immigrants,
    created like founders, also arrive. If `max_count` is reached, the remaining slots are shared at random
    among newborns and immigrants.
    """

    needs = (Position, Body, Metabolism, Biology)
    phase = "reproduce"
    divisible = True
    submodel = Submodel(
        "Reproduction by single parents",
        where=("reproduction.kind=simplified", "reproduction.kind=asexual"),
        reads=("reproduction",),
        rules={
            "reproduction.age_min": "A parent is at least `age_min` old.",
            "": "A parent with at least `energy_min` gives birth in a tick with probability `1 − exp(−rate × "
            "fertility × dt)`, more than once if the energy lasts (Poisson), and pays `energy_given` for "
            "each newborn, unless its energy would fall to 0. Fertility is 1 unless given.",
            "reproduction.place=anywhere": "A newborn appears at a random place that no opaque body, water or "
            "rock covers.",
            "reproduction.place=near": "A newborn appears at a random place within `dispersal` of its parent "
            "that no opaque body, water or rock covers.",
            "reproduction.spacing": "A birth fails if another member of the species is within `spacing`.",
            "reproduction.immigration": "`immigration dt` immigrants arrive in a tick; any fractional part "
            "is the probability of one more.",
            "max_count": "If `max_count` would be exceeded, the remaining slots are allocated at random.",
        },
        changes=("Metabolism.energy", "Metabolism.given"),
        draws="the number of births, and the places and headings of newborns",
    )
    # scratch lists of parents: rows, numbers of newborns, and payments; as long as the largest table so far
    _lists: tuple[np.ndarray, ...] = (np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0, np.float32))

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Reproduce one species."""
        way = table.species.reproduction
        if (
            way is None
            or way.kind not in ("simplified", "asexual")
            or not (world.reproduction or table.species.nerves is None)
        ):
            return  # animals do not reproduce during pre-training; plants do
        m, b = table[Metabolism], table[Biology]
        lives = life_history(table, way)
        if self._lists[0].size < table.high:
            self._lists = tuple(np.empty(table.capacity, kind) for kind in (np.int64, np.int64, np.float32))
        parents, number, given = self._lists
        rate = own_value(table, "reproduction.rate", way.rate) if table.species.traits else way.rate
        chance = (chance_of if isinstance(rate, np.ndarray) else _shared_chance)(rate, world.dt)
        living = world.bands.living(table) if world.bands.divided else table.alive
        n = ready(
            living[: table.high],
            m.energy,
            b.age,
            b.fertility,
            table.uid,
            lives,
            chance,
            world.key,
            parents,
            number,
            given,
        )
        if n == 0 and not (world.bands.divided or way.immigration):
            return
        order = table.uid[parents[:n]].argsort()
        parents, number, given = parents[order], number[order], given[order]
        pay(parents, bring_forth(table, world, way, parents, number, given), given, m.energy, m.given)


def chance_of(rate: Number, dt: float) -> Any:
    """Return the probability of a birth in a tick at a given rate [1/s], or at individual rates."""
    chance = 1 - arrays.exp(-rate * dt)
    return chance.astype(np.float32) if isinstance(rate, np.ndarray) else np.float32(chance)


_shared_chance = lru_cache(256)(chance_of)  # the same few rates recur


@njit
def ready(
    alive: np.ndarray,
    energy: np.ndarray,
    age: np.ndarray,
    fertility: np.ndarray,
    uid: np.ndarray,
    lives: Lives,
    chance: Number,
    key: np.uint64,
    parents: np.ndarray,
    number: np.ndarray,
    given: np.ndarray,
) -> int:
    """List the parents, each one's maximum number of newborns, and its payment per newborn; return the number
    of parents."""
    own, age_min, energy_min, energy_given, litter, _ = lives
    n = 0
    for row in range(alive.size):
        i = row if own else 0
        if alive[row] and energy[row] >= energy_min[i] and age[row] >= age_min[i]:
            u, none = draw(key, uid[row], random.BIRTH), 1.0 - np.float64(of_row(chance, row))
            if fertility[row] != 1:
                none **= np.float64(fertility[row])
            if u < 1.0 - none:
                size = whole(litter[i])
                price, most = energy_given[i] * np.float32(size), np.float32(LITTER_MAX)
                if price > 0:
                    most = min((energy[row] - energy_min[i]) / price, most)
                times = number_of_births(u, none, 1 + int(most))
                number[n] = affordable(energy[row], energy_given[i], times * size)
                parents[n], given[n] = row, energy_given[i]
                n += number[n] > 0
    return n


@njit
def number_of_births(u, none, most):
    """Return the number of births in a tick, from 1 to `most`, given a random number u below 1 − none: a
    Poisson number that is 0 with probability `none`."""
    mean, n = -np.log(none) if none > 0 else 0.0, 1
    term = none * mean
    left = 1.0 - none - term
    while n < most and u < left:
        n += 1
        term *= mean / n
        left -= term
    return n


@njit
def pay(parents, born, each, energy, given):
    """Charge each parent for its newborns."""
    for i in range(parents.size):
        row = parents[i]
        before = energy[row]
        energy[row] = before - np.float32(born[i]) * each[i]
        given[row] += before - energy[row]
