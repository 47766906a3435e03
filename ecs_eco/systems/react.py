"""Metabolic reactions convert substances."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row, row_of
from ecs_eco.components import Chemistry, Matter, Metabolism, Position
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_values
from ecs_eco.life.matter import Bodies, bodies, book, held, hold
from ecs_eco.life.sizes import of_size

if TYPE_CHECKING:
    from ecs_eco.config.features.chemistry import Reaction
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

EVEN = np.zeros(0, np.float32)
NO_ENERGY = np.zeros(0, np.float32)


class Stores(NamedTuple):
    """Energy of organisms, for kernels: f32[rows], empty if they have no energy."""

    energy: np.ndarray
    taken: np.ndarray
    burnt: np.ndarray


class React(System):
    """A species' reactions convert substances in the body, in the order listed.

    The extent in a tick is rate × Π c/(half + c) × volume × dt (Michaelis & Menten 1913; the product over
    several substances after Monod 1949), multiplied by the light if the reaction needs light. A reaction with
    an action runs only in organisms that execute it; none runs in dying organisms. A reaction never consumes
    more than the body contains. A reaction that releases energy stops when the organism is full, and one that
    needs energy stops when the organism has none.
    """

    needs = (Chemistry, Matter)
    phase = "metabolise"
    submodel = Submodel(
        "Reactions",
        reads=("reactions",),
        changes=("Chemistry", "Matter", "Metabolism.energy", "Metabolism.taken", "Metabolism.burnt"),
    )
    asked_for = staticmethod(lambda table: bool(table.species.reactions))

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Run the reactions of one species."""
        species = table.species
        if not species.reactions:
            return
        living = (table.alive & (table.cause == 0))[: table.high]
        energy = taken = burnt = NO_ENERGY
        ceiling = 0.0
        if Metabolism in table:
            m = table[Metabolism]
            energy, taken, burnt = m.energy, m.taken, m.burnt
            ceiling = species.metabolism.energy_max
        light = self.light(table, world) if any(r.light for r in species.reactions) else EVEN
        made = np.zeros(len(world.substances))
        for number, reaction in enumerate(species.reactions):
            used, change, half = coefficients(reaction, world.substances)
            rate, gain, full, half = rates(table, world, number, half, ceiling)
            doing = (
                True
                if reaction.action is None
                else species.nerves.doing(table, reaction.action)[: table.high]
            )
            react(
                living & doing,
                bodies(table),
                used,
                change,
                half,
                rate * world.dt,
                light if reaction.light else EVEN,
                gain,
                full,
                Stores(energy, taken, burnt),
                made,
            )
        book(world, table, "reacted", made)

    def light(self, table: Table, world: SpatialWorld) -> np.ndarray:
        """Return the light at each organism's position: f32[high]."""
        p, high = table[Position], table.high
        return world.surroundings("light", p.x[:high], p.y[:high], p.z[:high]).astype(np.float32, copy=False)


def coefficients(reaction: Reaction, substances: list[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the consumption per mole of extent, the change of each substance [mol/mol], and the
    half-saturation concentrations [mol/L] (0: none): f64[substances] each."""
    used, made, half = (
        [amounts.get(s, 0.0) for s in substances]
        for amounts in (getattr(reaction, "from"), reaction.to, reaction.half)
    )
    return np.array(used), np.array(made) - np.array(used), np.array(half)


def rates(
    table: Table, world: SpatialWorld, number: int, half: np.ndarray, ceiling: float
) -> tuple[Any, ...]:
    """Return a reaction's rate and energy, the maximum energy of a body, and the half-saturation
    concentrations f64[substances]; all are arrays [high, …] if a gene codes for any of them."""
    reaction, key = table.species.reactions[number], f"reactions.{number}."
    own = own_values(
        table,
        {f"{key}rate": reaction.rate, f"{key}energy": reaction.energy, "metabolism.energy_max": ceiling}
        | {f"{key}half.{substance}": value for substance, value in reaction.half.items()},
    )
    if isinstance(own[0], np.ndarray):
        half = np.tile(half, (table.high, 1))
        for substance, each in zip(reaction.half, own[3:], strict=True):
            half[:, world.substances.index(substance)] = each
    return *own[:2], of_size(table, own[2]), half


@njit
def react(
    alive: np.ndarray,
    bodies: Bodies,
    used: np.ndarray,
    change: np.ndarray,
    half: np.ndarray,
    extent: Number,
    light: np.ndarray,
    energy_of: Number,
    ceiling: Number,
    stores: Stores,
    made: np.ndarray,
) -> None:
    """Run a reaction of at most `extent` [mol/L] in living bodies; add production minus consumption to `made`
    f64[substances] [mol]."""
    volume, (energy, taken, burnt) = bodies.volume, stores
    for row in range(alive.size):
        if not alive[row]:
            continue
        reach, gain, slow = of_row(extent, row), of_row(energy_of, row), row_of(half, row)
        if light.size:
            reach = reach * np.float64(light[row])
        for s in range(used.size):
            c = held(bodies, row, s)
            if slow[s] > 0:
                reach *= c / (slow[s] + c)
        for s in range(used.size):
            if used[s] > 0:
                reach = min(reach, held(bodies, row, s) / used[s])
        if energy.size and gain != 0:
            left = np.float64(of_row(ceiling, row)) - energy[row] if gain > 0 else np.float64(energy[row])
            reach = min(reach, max(left, 0.0) / (abs(gain) * volume[row]))
        if not reach > 0:
            continue
        for s in range(used.size):
            if change[s] != 0:
                before = held(bodies, row, s)
                now = hold(bodies, row, s, max(before + change[s] * reach, 0.0))
                made[s] += (now - before) * volume[row]
        if energy.size and gain != 0:
            before = energy[row]
            energy[row] = before + gain * reach * volume[row]
            taken[row] += max(energy[row] - before, np.float32(0))
            burnt[row] += max(before - energy[row], np.float32(0))
