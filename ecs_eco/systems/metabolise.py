"""Organisms pay for living and moving."""

from typing import Any

import numpy as np

from ecs_eco._numba import njit
from ecs_eco.components import Metabolism, Velocity
from ecs_eco.system import System

STILL = np.zeros(1, np.float32)


class Metabolise(System):
    """An organism burns its basal rate and the cost of its locomotion; what it cannot pay stays owed until it starves."""

    needs = (Metabolism,)
    phase = "metabolise"

    def update(self, table: Any, world: Any) -> None:
        """Burn the energy of one species for a tick."""
        species, m = table.traits.get("species"), table[Metabolism]
        cost = table[Velocity].cost if Velocity in table else STILL
        basal = species.metabolism.basal if species is not None else 0.0
        world.split(burn, table.high, table.alive, cost, cost is not STILL, np.float32(basal), np.float32(world.dt),
                    m.energy, m.digesting, m.burnt)


@njit
def burn(first, last, alive, cost, moves, basal, dt, energy, digesting, burnt):
    """Burn (basal + cost) dt of the energy of the living; digestion goes on."""
    for row in range(first, last):
        if alive[row]:
            before = energy[row]
            energy[row] = before - (basal + (cost[row] if moves else np.float32(0.0))) * dt
            burnt[row] += before - energy[row]
            digesting[row] = max(digesting[row] - dt, np.float32(0.0))
