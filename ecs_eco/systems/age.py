"""Organisms grow older."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Biology
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Age(System):
    """Each tick makes every organism `dt` seconds older.

    Age is computed from the tick of birth and rounded once, because summing steps in float32 would drift. If
    an age has been set, aging continues from that value.
    """

    needs = (Biology,)
    phase = "metabolise"
    divisible = True
    submodel = Submodel("Aging", changes=("Biology.age", "Biology.head_start"))

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Update the ages of one species."""
        biology, high = table[Biology], table.high
        world.split(
            grow_old,
            high,
            table.alive,
            table.born,
            world.tick,
            world.dt,
            biology.age,
            biology.head_start,
            work=high // 8,
        )


@njit
def grow_old(first, last, alive, born, tick, dt, age, head_start):
    """Set the end-of-tick age [s] of living organisms in rows first … last − 1; adjust `head_start` if an age
    was set from outside."""
    for k in range(last - first):
        row = np.uint64(first + k)
        if alive[row]:
            # newborns have age 0 in their tick of birth, because births follow this system
            before = (tick - born[row] - 1) * dt
            if age[row] != np.float32(before + head_start[row]):
                head_start[row] = age[row] - before
            age[row] = np.float32((tick - born[row]) * dt + head_start[row])
