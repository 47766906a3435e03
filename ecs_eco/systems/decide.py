"""Organisms decide: H(y + z)."""

from typing import Any

import numpy as np

from ecs_eco.components import Nervous
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
        choice = np.zeros((n, groups), np.int16)
        if nerves.policy and n:
            from ecs_eco.learning import choose

            chance, log_probability = np.empty((n, groups), np.float32), np.empty(n, np.float32)
            world.split(uniforms, n, world.key, table.uid[nerves.rows], chance)
            if nerves.brain is None:
                logits, values = np.zeros((n, int(nerves.offsets[-1])), np.float32), np.zeros(n, np.float32)
            else:
                logits, values = nerves.brain.forward(nerves.x, workers=world.threads)
            choose(logits, nerves.offsets, chance, choice, log_probability)
            if nerves.learning:
                nerves.learner.rollout.store(nerves.rows, nerves.x, choice, log_probability, values)
        y = NO_REFLEX if nerves.reflex is None else nerves.reflex(nerves.x)
        world.split(decide, n, choice, nerves.offsets, nerves.targets, nerves.policy, y, nerves.reflex is not None, nerves.automatic,
                    nerves.rows, table[Nervous].decision)
