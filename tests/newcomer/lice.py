"""Lice: a component and a system of a newcomer's own, in the package that ecs-eco new made."""

import numpy as np

from ecs_eco import System, component, f32
from ecs_eco.components import Metabolism


@component
class Lice:
    """The lice on one animal."""

    number: f32 = 1.0


class Bite(System):
    """Lice multiply, and drink."""

    needs = (Lice, Metabolism)
    phase = "metabolise"

    def start(self, world):
        for table in world.tables.values():
            if Metabolism in table and table.name == "rabbit":
                table.add_component(Lice)

    def update(self, table, world):
        table[Lice].number[table.alive] *= np.float32(1.01)
        drunk = np.float32(1e-5) * table[Lice].number[table.alive]
        table[Metabolism].energy[table.alive] -= drunk
        table[Metabolism].burnt[table.alive] += drunk
