"""Organisms feel happiness; its change is the reward."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Nervous
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.nervous.formula_steps import AS_READ, BLOCK, Steps, take_steps
from ecs_eco.nervous.networks import HappinessNetwork

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.nervous.nerves import Nerves
    from ecs_eco.space.world import SpatialWorld

NO_LEAST = np.float32(-np.inf)


class Feel(System):
    """The happiness network reads the sensors; the change in happiness since the last tick is the reward for
    the last decision.

    Happiness at t is a function of the observations at t, so feeling follows sensing. A newborn has no
    previous happiness and gets no reward. Custom systems in the `feel` phase run after this one and may write
    `Nervous.reward`; the learner reads it at the end of the phase.
    """

    needs = (Nervous,)
    phase = "feel"
    divisible = True
    submodel = Submodel(
        "Happiness and reward",
        where=("happiness",),
        reads=("happiness",),
        rules={
            "": "`happiness(t) = max(minimum, f(x(t)))` and `reward(t) = happiness(t) − happiness(t − 1)` "
            "(Strannegård et al. 2021), where f is the formula or the weighted sum of readings. A newborn's "
            "first reward is 0. At death, `minimum − happiness(t)` is added to the reward."
        },
        changes=("Nervous.happiness", "Nervous.reward", "Nervous.awake"),
    )

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Update the happiness and reward of one species."""
        nerves = table.species.nerves
        if (source := _source(nerves, table)) is None:
            return
        x, steps, least = source
        n = table[Nervous]
        world.split(
            feel,
            nerves.rows.size,
            nerves.rows,
            x,
            *steps,
            least,
            n.happiness,
            n.reward,
            n.awake,
            work=nerves.rows.size // 3,
        )


def _source(nerves: Nerves, table: Table) -> tuple[np.ndarray, Steps, np.float32] | None:
    """Return the inputs of happiness: x [channels, n], the steps of a formula over x, and the minimum; None
    if there is no happiness network. If the steps only read x, x is the happiness itself."""
    network = nerves.happiness
    if (
        type(network) is HappinessNetwork
        and network.steps is not None  # a subclass may compute something else
        and not table.species.traits
    ):
        return nerves.x.T, network.steps, network.least
    happiness = nerves.feel(table)
    return None if happiness is None else (happiness[None], AS_READ, NO_LEAST)


@njit
def feel(first, last, rows, x, operation, operand, height, least, happiness, reward, awake):
    """Store the happiness of entries first … last − 1 (the result of a formula's steps, raised to at least
    `least`) and the reward, which is its change, or 0 for an organism's first happiness value."""
    pile = np.empty((height + 1, BLOCK), x.dtype)
    for start in range(first, last, BLOCK):
        size = min(BLOCK, last - start)
        take_steps(x, start, size, operation, operand, pile)
        for k in range(size):
            i, now = np.uint64(start + k), pile[0, k]
            row = np.uint64(rows[i])
            now = now if (now > least) | (now != now) else least  # like numpy's maximum
            reward[row] = now - happiness[row] if awake[row] else np.float32(0.0)
            happiness[row] = now
            awake[row] = True
