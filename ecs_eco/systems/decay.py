"""Remains lose their energy."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.elementary import scalars
from ecs_eco.compiled.jit import njit
from ecs_eco.components import Metabolism
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

CAUSE = "decayed"


class Decay(System):
    """Objects that hold energy lose a share of it per second to heat and to microorganisms, which are not
    modeled: dE/dt = −decay E (Olson 1963). After a given time, they vanish."""

    needs = (Metabolism,)
    phase = "metabolise"
    submodel = Submodel(
        "Decay of energy", reads=("energy",), changes=("Metabolism.energy", "Metabolism.burnt")
    )
    asked_for = staticmethod(lambda table: table.species.energy is not None)

    def start(self, world: SpatialWorld) -> None:
        """Register the cause of death."""
        world.cause(CAUSE)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Decay one type of object."""
        store = table.species.energy
        if store is None or store.decay == 0:
            return
        last = math.inf if store.left == 0 else -scalars.log(store.left) / (store.decay * world.dt)
        m = table[Metabolism]
        # its tick of creation does not count, because objects are created after this system
        rot(
            table.alive[: table.high],
            table.born,
            world.tick,
            last,
            np.float32(-scalars.expm1(-store.decay * world.dt)),
            world.cause(CAUSE),
            m.energy,
            m.burnt,
            table.cause,
        )


@njit
def rot(alive, born, tick, last, share, decayed, energy, burnt, cause):
    """Remove a share of each object's energy; mark objects that are `last` ticks old."""
    for row in range(alive.size):
        if alive[row]:
            before = energy[row]
            energy[row] = before - share * before
            burnt[row] += before - energy[row]
            if cause[row] == 0 and tick - born[row] >= last:
                cause[row] = decayed
