"""Organisms decide: H(y + z)."""

from typing import Any

import numpy as np

from ecs_eco.components import Nervous
from ecs_eco.learning import choose
from ecs_eco.nervous.decision import decide, uniforms
from ecs_eco.system import System

NO_REFLEX = np.zeros((1, 1), np.int8)


class Decide(System):
    """The reflex network blocks (−1), leaves (0) or forces (+1) each action; the policy picks one of each group."""

    needs = (Nervous,)
    phase = "decide"

    def update(self, table: Any, world: Any) -> None:
        """Write the decisions of one species; keep what its learner needs."""
        nerves = table.traits["nerves"]
        n, groups = len(nerves.rows), len(nerves.choices)
        choice, log_probability = np.zeros((n, groups), np.int16), np.empty(n, np.float32)
        thinks = nerves.policy and n > 0
        if not thinks or nerves.brain is None:
            logits, values = np.zeros((n, int(nerves.offsets[-1])), np.float32), np.zeros(n, np.float32)
        else:
            logits, values = nerves.brain.forward(nerves.x, workers=world.threads)
        y = NO_REFLEX if nerves.reflex is None else nerves.reflex(nerves.x)
        uid, key, decision = table.uid[nerves.rows], world.key, table[Nervous].decision
        chance = np.empty((n, groups), np.float32)

        def part(first: int, last: int) -> None:
            if thinks:
                uniforms(first, last, key, uid, chance)
                here = slice(first, last)
                choose(logits[here], nerves.offsets, chance[here], choice[here], log_probability[here])
            decide(first, last, choice, nerves.offsets, nerves.targets, nerves.policy, y, nerves.reflex is not None, nerves.automatic,
                   nerves.rows, decision)

        world.split(part, n)
        if thinks and nerves.learning:
            nerves.learner.rollout.store(nerves.rows, nerves.x, choice, log_probability, values)
