"""Pressure in bodies depends on depth."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Physical, Position
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Compress(System):
    """A compressible body has the ambient pressure at its position; other bodies keep the pressure they had
    at birth."""

    needs = (Position, Physical)
    phase = "metabolise"
    submodel = Submodel("Pressure in bodies", changes=("Physical.pressure",))
    asked_for = staticmethod(lambda table: table.species.body.compressible)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Set the pressure in one kind of body."""
        if table.species.body.compressible:
            p, high = table[Position], table.high
            around = world.surroundings("pressure", p.x[:high], p.y[:high], p.z[:high])
            equalise(table.alive[:high], around.astype(np.float32, copy=False), table[Physical].pressure)


@njit
def equalise(alive, around, pressure):
    """Set the pressure [Pa] in living bodies to the ambient pressure."""
    for row in range(alive.size):
        if alive[row]:
            pressure[row] = around[row]
