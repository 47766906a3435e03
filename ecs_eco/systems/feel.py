"""Organisms feel: happiness, and the reward, which is its change."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Nervous
from ecs_eco.engine.jit import njit
from ecs_eco.engine.system import System

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Feel(System):
    """The happiness network reads the sensors; the change since the last tick rewards the last decision.

    Happiness at t is a function of what is sensed at t, so feeling follows sensing. A newborn has no earlier
    happiness and no reward.
    """

    needs = (Nervous,)
    phase = "feel"

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Update happiness and reward of one species; hand the rewards to its learner."""
        nerves = table.species.nerves
        happiness = nerves.feel(table)
        if happiness is None:
            return
        reward = np.empty(len(happiness), np.float32)
        n = table[Nervous]
        world.split(feel, len(reward), nerves.rows, happiness, n.happiness, n.reward, n.awake, reward,
                    work=len(reward) // 3)
        if nerves.learning:
            nerves.credit(table, reward)


@njit
def feel(first, last, rows, now, happiness, reward, awake, credit):
    """Store happiness and its change of entries first … last − 1; the first feeling of a life changes
    nothing."""
    for k in range(last - first):
        i = np.uint64(first + k)
        row = rows[i]
        credit[i] = now[i] - happiness[row] if awake[row] else np.float32(0.0)
        reward[row] = credit[i]
        happiness[row] = now[i]
        awake[row] = True
