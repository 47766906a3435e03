"""Time passes for everyone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Biology
from ecs_eco.engine.jit import lone_njit
from ecs_eco.engine.system import System

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Age(System):
    """Every organism is `dt` seconds older after a tick.

    Age follows from the tick of birth, rounded once: a sum of steps in float32 would drift. If an age was
    set, it is counted from there.
    """

    needs = (Biology,)
    phase = "metabolise"

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Let one species age."""
        biology, high = table[Biology], table.high
        world.split(grow_old, high, table.alive, table.born, world.tick, world.dt, biology.age,
                    biology.head_start, work=high // 8)


@lone_njit
def grow_old(first, last, alive, born, tick, dt, age, head_start):
    """Give the living of rows first … last − 1 their age at the end of a tick [s]; `head_start` follows an
    age that was set. Without branches, so that it becomes vector code."""
    for k in range(last - first):
        row = np.uint64(first + k)
        lives, now, start = alive[row], age[row], head_start[row]
        # a newborn has age 0 in its tick of birth, which comes after this system
        before = (tick - born[row] - 1) * dt
        later = start if now == np.float32(before + start) else now - before
        after = np.float32((tick - born[row]) * dt + later)
        head_start[row] = later if lives else start
        age[row] = after if lives else now
