"""Ectotherms slow down in the cold."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.elementary import power
from ecs_eco.components import Metabolism, Position, SpeedScale
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_value, own_values
from ecs_eco.life.climate import temperatures
from ecs_eco.life.sizes import upkeep
from ecs_eco.life.torpor import LEAST_ENERGY, awake

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class SlowDown(System):
    """In each tick, an ectotherm's speed and basal rate are multiplied by q10 ** ((T - reference) / 10 K); at
    or below its torpor temperature, it does not move."""

    needs = (Position, Metabolism, SpeedScale)
    phase = "environment"
    submodel = Submodel(
        "Temperature dependence",
        reads=("ectothermy",),
        rules={
            "": "`pace = q10^((T − reference)/10 K)` (van 't Hoff 1884). Speed is multiplied by "
            "pace, and cost by its square."
        },
        changes=("SpeedScale.pace",),
    )
    asked_for = staticmethod(lambda table: table.species.ectothermy is not None)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Set the pace of one species, and credit the basal energy that Metabolise will overcharge."""
        if (way := table.species.ectothermy) is None:
            return
        high, alive, m = table.high, table.alive[: table.high], table[Metabolism]
        q10, reference, torpor = own_values(
            table, {f"ectothermy.{key}": getattr(way, key) for key in ("q10", "reference", "torpor")}
        )
        warmth = temperatures(table, world).astype(np.float64)
        rate = power(q10, (warmth - reference) / 10.0)
        table[SpeedScale].pace[:high][alive] = np.where(warmth > torpor, rate, 0.0)[alive]
        basal = own_value(table, "metabolism.basal", table.species.metabolism.basal)
        full = basal if table.species.standard_mass is None else basal * upkeep(table)
        credit = np.where(awake(table)[:high], (1.0 - rate) * full * world.dt, 0.0)[alive]
        before = m.energy[:high][alive]
        least = np.minimum(before, LEAST_ENERGY[table.species.metabolism.torpor])
        m.energy[:high][alive] = np.maximum(before + credit, least)
        m.burnt[:high][alive] -= m.energy[:high][alive] - before
