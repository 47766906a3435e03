"""Organisms burn energy to live and move."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.compiled.jit import lone_njit
from ecs_eco.compiled.per_row import of_row
from ecs_eco.components import Metabolism, Velocity
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_value
from ecs_eco.life.sizes import upkeep
from ecs_eco.life.torpor import LEAST_ENERGY

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

STILL = np.zeros(1, np.float32)
NO_SCALE = np.zeros(0, np.float32)

KLEIBER = "The basal rate is multiplied by `(mass/{}mass)^0.75` (Kleiber 1932)."
CODED = [
    f"genome.{part}.trait=body.{trait}"
    for part in ("genes", "derived")
    for trait in ("mass", "radius & body.density")
]


class Metabolise(System):
    """An organism burns energy at its basal rate plus the cost of locomotion; its energy may fall below 0
    before it starves. An organism that can fall into torpor burns no more than it has.

    If mass is heritable, directly or through radius and density, or if the young grow, the basal rate scales
    with mass to the power of 3/4 (Kleiber 1932). Large bodies then burn more in total, but less per kilogram.
    """

    needs = (Metabolism,)
    phase = "metabolise"
    divisible = True
    submodel = Submodel(
        "Metabolism",
        where=("metabolism.basal", "locomotion.cost", "diet"),
        reads=("metabolism",),
        rules={
            "": "`dE/dt = −(basal + cost)`, where cost is the locomotion cost in this tick.",
            "diet": "The handling time of the last meal runs down.",
            "growth": KLEIBER.format("adult "),
            **dict.fromkeys(CODED, KLEIBER.format("body.")),
            "metabolism.torpor": "An animal without energy is torpid: it burns nothing and stands still.",
        },
        changes=("Metabolism.energy", "Metabolism.burnt", "Metabolism.digesting"),
    )

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Burn the energy of one species for one tick."""
        way, m = table.species.metabolism, table[Metabolism]
        cost = table[Velocity].cost if Velocity in table else STILL
        basal: Any = np.float32(way.basal)
        if table.species.traits:
            basal = own_value(table, "metabolism.basal", basal)
        scale = NO_SCALE if table.species.standard_mass is None else upkeep(table)
        world.split(
            burn,
            table.high,
            table.alive,
            scale,
            cost,
            cost is not STILL,
            basal,
            np.float32(world.dt),
            LEAST_ENERGY[way.torpor],
            m.energy,
            m.digesting,
            m.burnt,
            work=table.high // 5,
        )


@lone_njit
def burn(first, last, alive, scale, cost, moves, basal, dt, least, energy, digesting, burnt):
    """Burn (basal + cost) dt of each living organism's energy, which does not fall below `least`, and count
    down handling times. Branch-free, so that it vectorizes."""
    zero = np.float32(0.0)
    for k in range(last - first):
        row = np.uint64(first + k)
        lives, before, digests = alive[row], energy[row], digesting[row]
        own = of_row(basal, row)
        upkeep = own * scale[row] if scale.size else own
        after = before - (upkeep + (cost[row] if moves else zero)) * dt
        lowest = before if before < least else least
        after = after if after > lowest else lowest
        after = after if lives else before
        energy[row] = after
        burnt[row] += before - after
        digesting[row] = digests - 1 if lives & (digests > 0) else digests
