"""The part of PPO that learners with and without torch share: collecting a rollout in a population whose members
are born and die mid-rollout, estimating advantages, and going through the rollout in minibatches.

The code reads from top to bottom: `update` fills in the advantages and calls `fit`; `fit` goes through the
rollout in epochs of minibatches; a subclass takes the optimizer step. The hyperparameters are in settings.py,
and the log of transitions is in rollout.py.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from ecs_eco.learning.loss import LOSS_TERMS
from ecs_eco.learning.rollout import Rollout, summarize
from ecs_eco.learning.settings import PPO
from ecs_eco.space.one_band import OneBand

# transitions per pass through a network; fixed, so that sums do not depend on the number of workers
CHUNK = 2048


class RolloutLearner:
    """PPO without its optimizer; see the subclasses `Learner` and `TorchLearner`."""

    def __init__(self, brain: Any, ppo: PPO, seed: int, workers: int = 1) -> None:
        self.brain, self.ppo, self.seed, self.workers = brain, ppo, seed, workers
        self.rollout = Rollout(
            brain.n_observations, len(brain.offsets) - 1, ppo.discount, brain.memory, brain.n_numbers
        )
        self._lives = self._stretches = np.zeros(0, np.int64)  # while a brain with memory learns
        self.updates = 0
        self.bands = OneBand()  # the processes that share the work

    @property
    def full(self) -> bool:
        """Whether the rollout has reached its horizon."""
        return self.rollout.ticks >= self.ppo.horizon

    def update(self, rows: np.ndarray, values: np.ndarray) -> dict[str, float] | None:
        """Learn from the rollout, and clear it.

        Parameters
        ----------
        rows : array of int64, shape (n,)
            Rows of living organisms.
        values : array of float32, shape (n,)
            Values of their current observations, which estimate their future rewards.

        Returns
        -------
        dict of str to float or None
            Losses, entropy, clipped share and more; None if a shared learner waits for other worlds.
        """
        self.rollout.advantages(rows, values, self.ppo.gae_lambda)
        return self.fit()

    def fit(self) -> dict[str, float]:
        """Learn from a rollout whose advantages are known, and clear it; return the result of `update`."""
        ppo, rollout = self.ppo, self.rollout
        done = min(1.0, self.updates * ppo.horizon / ppo.anneal) if ppo.anneal else 0.0
        rate, clip = ppo.learning_rate * (1 - done), ppo.clip * (1 - done)
        shift, scale, explained, reward = summarize(rollout.steps, ppo.normalise_advantage)
        generator = np.random.Generator(np.random.Philox(key=[self.seed, self.updates]))
        if (
            self.brain.memory
        ):  # stretches of a life are shuffled if the brain has memory, otherwise single transitions
            self._lives, self._stretches = rollout.stretches(ppo.unroll)
        n = len(self._stretches) - 1 if self.brain.memory else rollout.n
        parts = max(1, -(-rollout.n // ppo.minibatch_size))
        edges = [n * i // parts for i in range(parts + 1)]
        terms, steps = np.zeros(len(LOSS_TERMS) + 1), 0
        for _ in range(ppo.epochs if n else 0):
            order = generator.permutation(n)
            for start, stop in pairwise(edges):
                if stop > start:
                    terms += self._step(order[start:stop], rate, clip, shift, scale)
                    steps += 1
                    if not np.isfinite(terms[-1]):
                        raise FloatingPointError(
                            f"update {self.updates}: the gradient is {terms[-1]}; observations, "
                            "rewards and values must be finite"
                        )
        terms /= max(1, steps)
        n_transitions = rollout.n
        rollout.clear()
        self.updates += 1
        return dict(zip((*LOSS_TERMS, "gradient_norm"), terms.tolist(), strict=True)) | {
            "explained_variance": explained,
            "reward": reward,
            "learning_rate": rate,
            "n_transitions": n_transitions,
        }

    def by_uid(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        """Return a `state()` that identifies organisms by uid instead of row; `rows` i64[n] are the living
        organisms, sorted by uid."""
        kept = {key: array for key, array in self.state().items() if not key.startswith("rollout.")}
        return kept | {f"rollout.{key}": array for key, array in self.rollout.by_uid(rows).items()}

    def state(self) -> dict[str, np.ndarray]:
        """Return copies of everything needed to continue learning: weights, optimizer, rollout, counters."""
        return {
            **{f"brain.{name}": array for name, array in self.brain.state().items()},
            **{f"rollout.{name}": array for name, array in self.rollout.state().items()},
            **self._optimiser_state(),
            "updates": np.array(self.updates),
        }

    def load(self, state: dict[str, np.ndarray]) -> None:
        """Continue from a `state()`. Raises ValueError if the network or the rollout has a different shape."""

        def part(name: str) -> dict[str, np.ndarray]:
            return {key.removeprefix(name): array for key, array in state.items() if key.startswith(name)}

        self.brain.load(part("brain."))
        self.rollout.load(part("rollout."))
        self._load_optimiser(state)
        self.updates = int(state["updates"])

    def _step(self, chosen: np.ndarray, rate: float, clip: float, shift: float, scale: float) -> np.ndarray:
        """Take one optimizer step to reduce the mean loss over the `chosen` i64[k] transitions or stretches.

        Returns the means of the loss's terms and the gradient's norm; if the norm is not finite, nothing
        changes.
        """
        raise NotImplementedError

    def _optimiser_state(self) -> dict[str, np.ndarray]:
        """Return copies of the optimizer's state by name."""
        raise NotImplementedError

    def _load_optimiser(self, state: dict[str, np.ndarray]) -> None:
        """Continue from an `_optimiser_state()`."""
        raise NotImplementedError
