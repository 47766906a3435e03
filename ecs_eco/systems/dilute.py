"""Growing bodies dilute their substances."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Body, Chemistry, Matter
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.life.matter import Bodies, bodies, held, hold, volumes

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Dilute(System):
    """Growth dilutes a body's substances and shrinkage concentrates them; amounts stay the same."""

    needs = (Body, Chemistry, Matter)
    phase = "environment"
    submodel = Submodel(
        "Dilution",
        where=("growth", "genome"),
        rules={"": "`c ← c V_before / V_now`: the amount of each substance stays the same."},
        changes=("Chemistry", "Matter"),
    )
    asked_for = staticmethod(lambda table: Matter in table)

    def start(self, world: SpatialWorld) -> None:
        """Record the body volume of newborns from now on."""
        world.on_birth.append(measure)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Adjust the concentrations of one table to its bodies' current volumes."""
        high = table.high
        dilute(table.alive[:high], volumes(table), bodies(table))


def measure(table: Table, rows: np.ndarray, parents: np.ndarray, second: np.ndarray) -> None:
    """Set the volume to which the concentrations of newborns in rows i64[k] refer."""
    if Matter in table:
        volume = table[Matter].volume
        volume[rows] = np.where(volume[rows] > 0, volume[rows], volumes(table)[rows])


@njit
def dilute(alive: np.ndarray, wanted: np.ndarray, bodies: Bodies) -> None:
    """Adjust the concentrations of living bodies to the volumes `wanted` f64[rows] [L]."""
    volume = bodies.volume
    for row in range(alive.size):
        if alive[row] and wanted[row] != volume[row]:
            if volume[row] > 0 and wanted[row] > 0:
                share = volume[row] / wanted[row]
                for s in range(bodies.molarity.shape[1]):
                    hold(bodies, row, s, held(bodies, row, s) * share)
            volume[row] = wanted[row]
