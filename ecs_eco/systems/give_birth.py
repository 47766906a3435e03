"""Pregnant mothers give birth."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Biology, Body, Gestation, Metabolism, Position
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_values
from ecs_eco.life.births import Lives, Wombs, affordable, bring_forth, life_history, ticks, wombs_of
from ecs_eco.life.sizes import of_size

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class GiveBirth(System):
    """At term, a mother gives birth to her litter and pays the share that the father has not paid.

    The litter is limited by the energy that she can spend, by `max_count` and by the number of free
    positions. She keeps the father's payment for young that could not be born, up to her capacity; this
    amount is deducted from the parents' expenses. An unborn litter dies with its mother.
    """

    needs = (Position, Body, Metabolism, Biology, Gestation)
    phase = "reproduce"
    divisible = True
    submodel = Submodel(
        "Sexual reproduction",
        where=("reproduction.kind=sexual",),
        rules={
            "reproduction.place=near": "A newborn appears at a random place within `dispersal` of its mother, "
            "by default four body radii, that no opaque body, water or rock covers.",
            "reproduction.place=anywhere": "A newborn appears at a random place that no opaque body, water or "
            "rock covers.",
        },
        changes=("Gestation", "Metabolism.energy", "Metabolism.given"),
        draws="the places and headings of newborns",
    )

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Run the births of one species."""
        way = table.species.reproduction
        if way is None or way.kind != "sexual" or not world.reproduction:
            return
        m, g = table[Metabolism], table[Gestation]
        lives, wombs = life_history(table, way), wombs_of(table)
        mothers, number = np.empty(table.high, np.int64), np.empty(table.high, np.int64)
        n = at_term(
            world.bands.living(table)[: table.high], wombs, world.tick, m.energy, lives, mothers, number
        )
        if n == 0 and not world.bands.divided:
            return
        order = np.argsort(table.uid[mothers[:n]])
        mothers, number = mothers[order], number[order]
        each = lives.energy_given
        given = each[mothers] if lives.own else np.full(n, each[0], np.float32)
        born = bring_forth(table, world, way, mothers, number, given, g.father[mothers], g.sperm[mothers])
        store, rest = own_values(
            table,
            {
                "metabolism.energy_max": np.float32(table.species.metabolism.energy_max),
                "reproduction.rest": way.rest,
            },
        )
        deliver(
            mothers,
            born,
            given,
            of_size(table, store),
            world.tick + ticks(rest, world.dt),
            m.energy,
            m.given,
            wombs,
        )
        g.sperm[mothers] = 0


@njit
def her_part(given, stored, carrying):
    """Return the mother's payment per newborn."""
    return max(given - stored / np.float32(carrying), np.float32(0.0))


@njit
def at_term(
    alive: np.ndarray,
    wombs: Wombs,
    tick: int,
    energy: np.ndarray,
    lives: Lives,
    mothers: np.ndarray,
    number: np.ndarray,
) -> int:
    """List the mothers at term, and how many newborns each can pay for; return the number of mothers."""
    carrying, due, _, stored, _ = wombs
    n, own, energy_given = 0, lives.own, lives.energy_given
    for row in range(alive.size):
        if alive[row] and carrying[row] and due[row] <= tick:
            part = her_part(energy_given[row if own else 0], stored[row], carrying[row])
            mothers[n], number[n] = row, affordable(energy[row], part, np.int64(carrying[row]))
            n += 1
    return n


@njit
def deliver(
    mothers: np.ndarray,
    born: np.ndarray,
    given_each: np.ndarray,
    energy_max: Number,
    rested: Number,
    energy: np.ndarray,
    given: np.ndarray,
    wombs: Wombs,
) -> None:
    """Charge the mothers for their newborns, refund the father's payment for young that could not be born,
    and start the mothers' rest period."""
    carrying, _, father, stored, rest = wombs
    for i in range(mothers.size):
        row = mothers[i]
        before = energy[row]
        after = before - np.float32(born[i]) * her_part(given_each[i], stored[row], carrying[row])
        unused = stored[row] * np.float32(carrying[row] - born[i]) / np.float32(carrying[row])
        energy[row] = min(after + unused, max(after, of_row(energy_max, row)))
        given[row] += before - energy[row]
        carrying[row], stored[row], father[row], rest[row] = 0, 0, 0, of_row(rested, row)
