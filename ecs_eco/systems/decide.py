"""Organisms decide: H(y + z)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Nervous
from ecs_eco.engine.system import System
from ecs_eco.learning import choose
from ecs_eco.nervous.decision import decide, uniforms
from ecs_eco.nervous.thoughts import Thoughts

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

NO_REFLEX = np.zeros((1, 1), np.int8)
NO_THOUGHT = np.zeros((0, 0), np.float32), np.zeros(0, np.float32)


class Decide(System):
    """The reflex network blocks (−1), leaves (0) or forces (+1) each action;
    the policy picks one of each group."""

    needs = (Nervous,)
    phase = "decide"

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Write the decisions of one species; keep what its learner needs."""
        nerves = table.species.nerves
        n, groups = len(nerves.rows), len(nerves.choices)
        choice, log_probability = np.zeros((n, groups), np.int16), np.empty(n, np.float32)
        thinks = nerves.policy and n > 0
        logits, values = nerves.think(table, world) if thinks else NO_THOUGHT
        reacts = nerves.reflex is not None
        y = nerves.react(table) if reacts else NO_REFLEX
        uid, key, decision = table.uid[nerves.rows], world.key, table[Nervous].decision
        chance = np.empty((n, groups), np.float32)

        def part(first: int, last: int) -> None:
            if thinks:
                uniforms(first, last, key, uid, chance)
                here = slice(first, last)
                choose(logits[here], nerves.offsets, chance[here], choice[here], log_probability[here])
            decide(first, last, choice, nerves.offsets, nerves.targets, nerves.policy, y, reacts,
                   nerves.automatic, nerves.rows, decision)

        world.split(part, n)
        nerves.thoughts = Thoughts(world.tick, uid, logits if thinks else None, y if reacts else None, choice)
        if thinks and nerves.learning:
            nerves.remember(table, choice, log_probability, values)
        if thinks:
            nerves.keep(table)
