"""Plants gain energy from light."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import of_row
from ecs_eco.components import Growth, Metabolism, Position
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_value
from ecs_eco.life.defence import left_by_defence
from ecs_eco.life.sizes import of_size
from ecs_eco.space.land import at_places

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Grow(System):
    """A plant gains `photosynthesis` [energy/s] in full light, proportionally less in weaker light, until it
    is full.

    The share that it spends on its defense is not available for growth. Each land-cover class multiplies
    growth by a factor.
    """

    needs = (Position, Metabolism)
    phase = "environment"
    divisible = True
    submodel = Submodel(
        "Growth by light",
        where=("metabolism.photosynthesis", "genome.genes.trait=metabolism.photosynthesis"),
        rules={"": "`dE/dt = photosynthesis × light`, up to `energy_max`; light is 1 in full daylight."},
        changes=("Metabolism.energy", "Metabolism.taken"),
    )

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Grow one species, unless it lacks `photosynthesis`."""
        way = table.species.metabolism
        if way.photosynthesis == 0 and Growth not in table:
            return
        p, m, high = table[Position], table[Metabolism], table.high
        light = world.surroundings("light", p.x[:high], p.y[:high], p.z[:high])
        if Growth in table:
            light = light * table[Growth].growth[:high]
            rate = 1.0
        else:
            rate = way.photosynthesis
        light = light * left_by_defence(table, high)
        if world.terrain is not None and world.terrain.land is not None:
            if (land := world.terrain.land.growth) is not None:
                light = light * at_places(land, world.terrain, p.x[:high], p.y[:high])
        most = own_value(table, "metabolism.energy_max", np.float32(way.energy_max))
        world.split(
            grow,
            high,
            table.alive,
            light,
            np.float32(rate * world.dt),
            of_size(table, most),
            m.energy,
            m.taken,
        )


@njit
def grow(first, last, alive, light, growth, ceiling, energy, taken):
    """Add light[row] × growth to the energy of living plants, up to the maximum."""
    for row in range(first, last):
        if alive[row]:
            before = energy[row]
            energy[row] = max(before, min(before + growth * light[row], of_row(ceiling, row)))
            taken[row] += energy[row] - before
