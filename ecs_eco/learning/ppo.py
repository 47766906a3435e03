"""Proximal policy optimisation (Schulman et al. 2017) for a population that is born and dies while it learns.

Read `Learner.update` from top to bottom: advantages, epochs of minibatches, the gradient of the loss by each logit
and value (`_slopes`), the network's backward pass (`Brain.back`), and one step of Adam (`_adam`). The hyperparameters
are in settings.py, the log of transitions in rollout.py, the network in brain.py.
"""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from ecs_eco.engine.jit import njit
from ecs_eco.engine.threads import in_parallel
from ecs_eco.learning.arithmetic import exp, fused_njit, softmax
from ecs_eco.learning.brain import CHUNK, Brain
from ecs_eco.learning.rollout import Rollout
from ecs_eco.learning.settings import PPO

# sums may be taken in any order here: always the same one for the same number of weights
_summing_njit: Any = partial(njit, fastmath={"contract", "reassoc"})
_TERMS = ("policy_loss", "value_loss", "entropy", "approx_kl", "clip_fraction")


class Learner:
    """Trains a brain on what the population lived through; `store`, `credit`, `end`, `cut` are those of `rollout`.

    A tick is: sense; credit, end, cut; if `full`, update with the values of what is sensed; decide; store.
    Results are the same bits for any number of `workers` (threads).
    """

    def __init__(self, brain: Brain, ppo: PPO, seed: int, workers: int = 1) -> None:
        import torch

        self.brain, self.ppo, self.seed, self.workers = brain, ppo, seed, workers
        self.rollout = Rollout(brain.n_observations, len(brain.groups), ppo.discount)
        self.updates = 0
        self.steps = 0  # of Adam
        self.moment_1, self.moment_2 = torch.zeros(brain.size), torch.zeros(brain.size)
        self._gradient = torch.zeros(0, brain.size)  # a row per chunk of a minibatch
        self._layers: list[Any] = []  # its views

    @property
    def full(self) -> bool:
        """Whether the rollout has its horizon's ticks."""
        return self.rollout.ticks >= self.ppo.horizon

    def update(self, rows: np.ndarray, values: np.ndarray) -> dict[str, float]:
        """Learn from the rollout and clear it; `values` f32[n] are those of what the living `rows` i64[n] sense now.

        Returns means over all gradient steps: policy_loss, value_loss, entropy [nat], approx_kl [nat], clip_fraction,
        gradient_norm; and explained_variance, reward (per transition), learning_rate, n_transitions.
        """
        self.rollout.advantages(rows, values, self.ppo.gae_lambda)
        return self.fit()

    def fit(self) -> dict[str, float]:
        """Learn from a rollout whose advantages are known, and clear it; returns what `update` does."""
        ppo, rollout = self.ppo, self.rollout
        done = min(1.0, self.updates * ppo.horizon / ppo.anneal) if ppo.anneal else 0.0
        rate, clip = ppo.learning_rate * (1 - done), ppo.clip * (1 - done)
        report = _summary(rollout.steps) | {"learning_rate": rate, "n_transitions": rollout.n}
        shift, scale = 0.0, 1.0
        if ppo.normalise_advantage and rollout.n > 1:
            advantage = rollout.steps["advantage"]
            shift, scale = advantage.mean(dtype=float), 1 / (advantage.std(dtype=float) + 1e-8)
        generator = np.random.Generator(np.random.Philox(key=[self.seed, self.updates]))
        parts = max(1, -(-rollout.n // ppo.minibatch))
        edges = [rollout.n * i // parts for i in range(parts + 1)]
        terms = np.zeros(len(_TERMS) + 1)
        for _ in range(ppo.epochs if rollout.n else 0):
            order = generator.permutation(rollout.n)
            for start, stop in pairwise(edges):
                terms += self._step(order[start:stop], rate, clip, shift, scale)
        terms /= max(1, ppo.epochs * parts)
        rollout.clear()
        self.updates += 1
        return dict(zip((*_TERMS, "gradient_norm"), terms.tolist(), strict=True)) | report

    def by_uid(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        """Return a `state()` in which organisms stand by uid, not by row; `rows` i64[n] are the living in the order of uids."""
        kept = {key: array for key, array in self.state().items() if not key.startswith("rollout.")}
        return kept | {f"rollout.{key}": array for key, array in self.rollout.by_uid(rows).items()}

    def state(self) -> dict[str, np.ndarray]:
        """Return copies of all that learning goes on from: weights, Adam, rollout, counters."""
        return {
            **{f"brain.{name}": array for name, array in self.brain.state().items()},
            **{f"rollout.{name}": array for name, array in self.rollout.state().items()},
            "moment_1": self.moment_1.numpy().copy(),
            "moment_2": self.moment_2.numpy().copy(),
            "updates": np.array(self.updates),
            "steps": np.array(self.steps),
        }

    def load(self, state: dict[str, np.ndarray]) -> None:
        """Go on from a `state()`; raises ValueError where the network or the rollout is of another shape."""

        def part(name: str) -> dict[str, np.ndarray]:
            return {key.removeprefix(name): array for key, array in state.items() if key.startswith(name)}

        self.brain.load(part("brain."))
        self.rollout.load(part("rollout."))
        self.moment_1.numpy()[...], self.moment_2.numpy()[...] = state["moment_1"], state["moment_2"]
        self.updates, self.steps = int(state["updates"]), int(state["steps"])

    def _step(self, index: np.ndarray, rate: float, clip: float, shift: float, scale: float) -> np.ndarray:
        """Take one step of Adam down the mean loss over the transitions `index`; return the terms and the norm."""
        brain, ppo, rollout = self.brain, self.ppo, self.rollout
        n_chunks = -(-len(index) // CHUNK)
        self._reserve(n_chunks)
        terms = np.zeros((n_chunks, len(_TERMS) + 1))
        weights = np.array([clip, ppo.clip_value, ppo.entropy, ppo.value_weight, shift, scale, 1 / len(index)], "f4")

        def work(worker: int) -> None:
            for chunk in range(worker, n_chunks, self.workers):
                chosen = index[chunk * CHUNK : (chunk + 1) * CHUNK]
                rows = brain.rows(worker, len(chosen))
                np.take(rollout.observations, chosen, 0, out=rows.observations, mode="clip")
                brain.run(rows)
                _slopes(
                    rows.logits, rows.values, brain.offsets, rollout.choices, rollout.steps, chosen,
                    *weights, rows.d_logits, rows.d_values, terms[chunk],
                )  # fmt: skip
                brain.back(rows, self._layers[chunk])

        in_parallel(work, self.workers)
        self.steps += 1
        total = terms.sum(axis=0) / len(index)
        total[-1] = _adam(
            brain.weights.numpy(), self._gradient.numpy()[:n_chunks], self.moment_1.numpy(), self.moment_2.numpy(),
            self.steps, rate, ppo.adam_epsilon, ppo.max_grad_norm, ppo.weight_decay,
        )  # fmt: skip
        if not np.isfinite(total[-1]):
            raise FloatingPointError(f"update {self.updates}: the gradient is {total[-1]}; observations, rewards and values must be finite")
        return total

    def _reserve(self, n_chunks: int) -> None:
        """Have a row of gradient for each chunk of a minibatch."""
        if n_chunks > len(self._layers):
            self._gradient = self._gradient.new_zeros(n_chunks, self.brain.size)
            self._layers = [self.brain.views(row) for row in self._gradient]


@fused_njit
def _slopes(
    logits, values, offsets, choices, steps, index, clip, clip_value, entropy_weight, value_weight, shift, scale, share,
    d_logits, d_values, terms,
):  # fmt: skip
    """Write the slope of the loss by each logit [k, n] and value [n], `share` per transition; add up the loss's terms.

    Loss = -min(r A, clip(r) A) - entropy_weight H + value_weight (V - R)^2, with r the ratio of the choice's
    probabilities now and then, A the advantage, R = A + V then (Schulman et al. 2017, eq. 7 and 9).
    """
    n, n_groups = len(index), len(offsets) - 1
    taken, lived = np.empty((n_groups, n), np.int64), np.empty((3, n), np.float32)
    level, spread = np.empty((n_groups, n), np.float32), np.empty((n_groups, n), np.float32)
    ratio, pull = np.zeros(n, np.float32), np.empty(n, np.float32)
    for i in range(n):  # from all over memory: nothing else happens here, so that the next is fetched meanwhile
        step = steps[index[i]]
        lived[0, i], lived[1, i], lived[2, i] = step.log_probability, step.value, step.advantage
        for g in range(n_groups):
            taken[g, i] = offsets[g] + max(0, min(choices[index[i], g], offsets[g + 1] - offsets[g] - 1))
    policy_loss = value_loss = entropy = kl = n_clipped = 0.0
    for g in range(n_groups):
        softmax(logits, offsets[g], offsets[g + 1], d_logits, level[g], spread[g])
        for i in range(n):
            ratio[i] += logits[taken[g, i], i] - level[g, i]
            entropy += spread[g, i]
    for i in range(n):
        pull[i] = ratio[i] - lived[0, i]
        ratio[i] = exp(pull[i])
    for i in range(n):
        gain, r = (lived[2, i] - shift) * scale, ratio[i]
        bound = min(max(r, 1 - clip), 1 + clip)
        kl += r - 1 - pull[i]
        clipped = (r > bound and gain > 0) or (r < bound and gain < 0)
        pull[i] = np.float32(0) if clipped else gain * r * share
        policy_loss -= min(r * gain, bound * gain)
        n_clipped += r != bound
        slope, error = _value_slope(values[i], lived[1, i], lived[1, i] + lived[2, i], clip_value)
        d_values[i] = slope * value_weight * share
        value_loss += error
    for g in range(n_groups):
        for k in range(offsets[g], offsets[g + 1]):
            for i in range(n):
                bonus = entropy_weight * share * (logits[k, i] - level[g, i] + spread[g, i])
                d_logits[k, i] *= pull[i] + bonus
        for i in range(n):
            d_logits[taken[g, i], i] -= pull[i]
    terms[0], terms[1], terms[2], terms[3], terms[4] = policy_loss, value_loss, entropy, kl, n_clipped


@fused_njit
def _value_slope(value, old, target, clip_value):
    """Return slope and size of the squared error; with clip_value, that of the worse of the free and the held value."""
    error = value - target
    if 0 < clip_value < abs(value - old):
        held = old + (clip_value if value > old else -clip_value)
        if (held - target) ** 2 > error**2:
            return np.float32(0), (held - target) ** 2
    return 2 * error, error**2


@_summing_njit
def _adam(weights, gradients, moment_1, moment_2, step, rate, epsilon, max_norm, decay=0.0):
    """Take Adam's step (Kingma and Ba 2015, algorithm 1) down the sum of the gradients' rows; return its length.

    Weights decay apart from the gradient (Loshchilov and Hutter 2019). If the gradient is not finite, nothing changes.
    """
    gradient = gradients[0]
    for c in range(1, len(gradients)):
        for i in range(len(gradient)):
            gradient[i] += gradients[c, i]
    square = 0.0
    for i in range(len(gradient)):
        square += np.float64(gradient[i]) ** 2
    norm = np.sqrt(square)
    if not np.isfinite(norm):
        return norm
    hold = np.float32(max_norm / (norm + 1e-6) if 0 < max_norm < norm else 1.0)
    scale, root = np.float32(rate / (1 - 0.9**step)), np.float32(1 / np.sqrt(1 - 0.999**step))
    keep = np.float32(1 - rate * decay)
    for i in range(len(gradient)):
        slope = gradient[i] * hold
        moment_1[i] += np.float32(0.1) * (slope - moment_1[i])
        moment_2[i] += np.float32(0.001) * (slope * slope - moment_2[i])
        weights[i] = weights[i] * keep - scale * moment_1[i] / (np.sqrt(moment_2[i]) * root + np.float32(epsilon))
    return norm


def _summary(steps: np.ndarray) -> dict[str, float]:
    """Return what the rollout says before it is learnt from; NaN where it says nothing."""
    if not len(steps):
        return {"explained_variance": float("nan"), "reward": float("nan")}
    target_variance = float((steps["advantage"] + steps["value"]).var(dtype=float))
    left = float(steps["advantage"].var(dtype=float))
    explained = 1 - left / target_variance if target_variance > 0 else float("nan")
    return {"explained_variance": explained, "reward": float(steps["reward"].mean(dtype=float))}
