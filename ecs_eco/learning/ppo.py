"""PPO for plain networks, several times as fast as autograd: the loss's slopes are a kernel,
and the way back is by hand.

torch_ppo.py says what is done here, and decides all but the gradient and the optimiser's step;
both are tested equal.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ecs_eco.engine.threads import in_parallel
from ecs_eco.learning.backward import CHUNK, Passes
from ecs_eco.learning.brain import Brain
from ecs_eco.learning.ppo_kernels import adam
from ecs_eco.learning.settings import PPO
from ecs_eco.learning.torch_ppo import TERMS, TorchLearner


class Learner(TorchLearner):
    """Trains a brain on what the population lived through; `store`, `credit`, `end`,
    `cut` are those of `rollout`.

    A tick is: sense; credit, end, cut; if `full`, update with the values of what is sensed; decide; store.
    Results are the same bits for any number of `workers` (threads).
    """

    brain: Brain

    def __init__(self, brain: Brain, ppo: PPO, seed: int, workers: int = 1) -> None:
        super().__init__(brain, ppo, seed, workers)
        self.steps = 0  # of Adam
        self.moment_1, self.moment_2 = np.zeros(brain.size, np.float32), np.zeros(brain.size, np.float32)
        self._passes = Passes(brain)
        self._gradient = np.zeros((0, brain.size), np.float32)  # a row per chunk of a minibatch

    def _optimiser(self) -> Any:
        return None  # Adam is a kernel here

    def _optimiser_state(self) -> dict[str, np.ndarray]:
        return {
            "moment_1": self.moment_1.copy(),
            "moment_2": self.moment_2.copy(),
            "steps": np.array(self.steps),
        }

    def _load_optimiser(self, state: dict[str, np.ndarray]) -> None:
        self.moment_1[...], self.moment_2[...] = state["moment_1"], state["moment_2"]
        self.steps = int(state["steps"])

    def _step(self, chosen: np.ndarray, rate: float, clip: float, shift: float, scale: float) -> np.ndarray:
        """Take one step of Adam down the mean loss over transitions;
        return the terms and the gradient's norm."""
        brain, passes, ppo, rollout = self.brain, self._passes, self.ppo, self.rollout
        n_chunks = -(-len(chosen) // CHUNK)
        if n_chunks > len(self._gradient):
            self._gradient = np.zeros((n_chunks, brain.size), np.float32)
        terms = np.zeros((n_chunks, len(TERMS) + 1))
        first, last = self.bands.part(n_chunks)
        settings = np.array(
            [clip, ppo.clip_value, ppo.entropy, ppo.value_weight, shift, scale, 1 / len(chosen)], "f4"
        )
        log = rollout.observations, rollout.choices, rollout.numbers, rollout.steps
        passes.begin(self.workers)

        def work(worker: int) -> None:
            for chunk in range(first + worker, last, self.workers):
                index, gradient = chosen[chunk * CHUNK : (chunk + 1) * CHUNK], self._gradient[chunk]
                passes.gradient(worker, index, log, settings, gradient, terms[chunk])
                if len(brain.spreads):
                    brain.views(gradient)[0][-1].matrix[brain.spreads] = 0  # biases alone

        in_parallel(work, self.workers)
        self.bands.whole(n_chunks, self._gradient, terms)
        self.steps += 1
        total: np.ndarray = terms.sum(axis=0) / len(chosen)
        total[-1] = adam(
            brain.weights,
            self._gradient[:n_chunks],
            self.moment_1,
            self.moment_2,
            self.steps,
            rate,
            ppo.adam_epsilon,
            ppo.max_grad_norm,
            ppo.weight_decay,
        )
        return total
