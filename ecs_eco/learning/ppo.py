"""PPO for plain networks, several times as fast as with autograd: the gradient and Adam's step are kernels.

Everything else is inherited from learner.py; tests compare it with torch_ppo.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ecs_eco.compiled.threads import in_parallel
from ecs_eco.learning.adam import adam
from ecs_eco.learning.brain import Brain
from ecs_eco.learning.gradient import scratch_for, shared_gradient
from ecs_eco.learning.learner import CHUNK, RolloutLearner
from ecs_eco.learning.loss import LOSS_TERMS, LossSettings
from ecs_eco.learning.settings import PPO


class Learner(RolloutLearner):
    """PPO for the built-in network, in a population whose members are born and die mid-rollout.

    Parameters
    ----------
    brain : Brain
    ppo : PPO
    seed : int
        Random seed for the order of minibatches.
    workers : int, default 1
        Number of threads, which affects speed, never results.

    Notes
    -----
    The steps of a tick are the same as for `TorchLearner`.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.learning import PPO, Brain, Learner
    >>> learner = Learner(Brain(3, groups=(2,)), PPO(horizon=8), seed=1)
    >>> learner.full, learner.update(np.zeros(1, np.int64), np.zeros(1, np.float32))["n_transitions"]
    (False, 0)
    """

    brain: Brain

    def __init__(self, brain: Brain, ppo: PPO, seed: int, workers: int = 1) -> None:
        super().__init__(brain, ppo, seed, workers)
        self.steps = 0  # of Adam
        self.moment_1, self.moment_2 = np.zeros(brain.size, np.float32), np.zeros(brain.size, np.float32)
        self._gradient = np.zeros((0, brain.size), np.float32)  # one row per chunk of a minibatch
        self._scratch: list[np.ndarray] = []  # of each worker

    def _optimiser_state(self) -> dict[str, np.ndarray]:
        moments = {"moment_1": self.moment_1, "moment_2": self.moment_2}
        kept = {name: _checkpoint_row(self.brain, moment) for name, moment in moments.items()}
        return kept | {"steps": np.array(self.steps)}

    def _load_optimiser(self, state: dict[str, np.ndarray]) -> None:
        for name, moment in (("moment_1", self.moment_1), ("moment_2", self.moment_2)):
            for part, kept in zip(
                self.brain.views(moment), _checkpoint_views(self.brain, state[name]), strict=True
            ):
                part[...] = kept
        self.steps = int(state["steps"])

    def _step(self, chosen: np.ndarray, rate: float, clip: float, shift: float, scale: float) -> np.ndarray:
        """Take one Adam step to reduce the mean loss over transitions; return the terms and the gradient's
        norm."""
        brain, ppo, rollout = self.brain, self.ppo, self.rollout
        n_chunks = -(-len(chosen) // CHUNK)
        if n_chunks > len(self._gradient):
            self._gradient = np.zeros((n_chunks, brain.size), np.float32)
        while len(self._scratch) < self.workers:
            self._scratch.append(scratch_for(brain.layers))
        terms = np.zeros((n_chunks, len(LOSS_TERMS) + 1))
        first, last = self.bands.part(n_chunks)
        numbers = clip, ppo.clip_value, ppo.entropy_coef, ppo.value_weight, shift, scale
        settings, share = LossSettings(*map(np.float32, numbers)), np.float32(1 / len(chosen))
        network = brain.weights, brain.layers, brain.offsets
        log = rollout.observations, rollout.choices, rollout.numbers, rollout.steps

        def work(worker: int) -> None:
            for chunk in range(first + worker, last, self.workers):
                index, gradient = chosen[chunk * CHUNK : (chunk + 1) * CHUNK], self._gradient[chunk]
                shared_gradient(
                    self._scratch[worker], *network, log, index, settings, share, gradient, terms[chunk]
                )
                if len(brain.spreads):
                    brain.named_views(gradient)["policy.head.weight"][brain.spreads] = 0  # only biases

        in_parallel(work, self.workers)
        self.bands.whole(n_chunks, self._gradient, terms)
        self.steps += 1
        total: np.ndarray = terms.sum(axis=0)
        how = rate, ppo.adam_epsilon, ppo.max_grad_norm, ppo.weight_decay
        gradients = self._gradient[:n_chunks]
        total[-1] = adam(brain.weights, gradients, self.moment_1, self.moment_2, self.steps, how)
        return total


def _checkpoint_row(brain: Brain, moment: np.ndarray) -> np.ndarray:
    """Return a moment of all weights in the form stored in checkpoints."""
    kept = np.zeros(sum(_whole_lines(math.prod(shape)) for shape in brain.shapes), np.float32)
    for part, place in zip(brain.views(moment), _checkpoint_views(brain, kept), strict=True):
        place[...] = part
    return kept


def _checkpoint_views(brain: Brain, kept: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the parts of a checkpoint's row in the same order as `shapes`: each begins at a multiple of 64
    bytes, and a head's matrix is (out, in)."""
    at = 0
    for a, b, *_, hidden in brain.layers.tolist():
        matrix = kept[at : at + a * b]
        yield matrix.reshape(a, b) if hidden else matrix.reshape(b, a).T
        at += _whole_lines(a * b)
        yield kept[at : at + b]
        at += _whole_lines(b)


def _whole_lines(n: int) -> int:
    """Return n numbers rounded up to a multiple of 64 bytes."""
    return -(-n // 16) * 16
