"""Brain: an actor-critic network of small tanh layers.

It thinks without torch; how it learns is in ppo.py.
"""

from __future__ import annotations

from contextlib import nullcontext

import numpy as np

from ecs_eco.compiled import portable
from ecs_eco.compiled.threads import one_blas_thread
from ecs_eco.learning.inference import infer_shared
from ecs_eco.learning.orthogonal import orthogonal
from ecs_eco.learning.plain_network import PlainNetwork
from ecs_eco.learning.policy_network import Split


class Brain(PlainNetwork):
    """A policy with a choice per action group, and a value, over the same observations.

    `groups` are the numbers of options of the categorical ones, then CONTINUOUS for each continuous one.

    `trunk` is "shared" (policy and value read the same hidden layers) or "separate" (each has its own).
    Weights are orthogonal, drawn from Philox keyed by (seed, layer), with gain sqrt(2); 0.01 for the policy's
    head and 1 for the value's.
    """

    def __init__(
        self,
        n_observations: int,
        groups: tuple[int, ...],
        hidden: tuple[int, ...] = (64, 64),
        seed: int = 0,
        trunk: str = "shared",
    ) -> None:
        super().__init__(n_observations, groups, hidden, trunk)
        if not hidden:
            raise ValueError(f"hidden = {hidden}: allowed is a tuple of one or more layer widths >= 1")
        self.weights = np.zeros(self.size, np.float32)
        self._draw(seed)

    def named(self) -> dict[str, np.ndarray]:
        """Return views of the weights by name, in torch's convention: weight (out, in), bias (out)."""
        return self.named_views(self.weights)

    def state(self) -> dict[str, np.ndarray]:
        """Return a copy of the weights by name."""
        return {name: np.array(weights, order="C") for name, weights in self.named().items()}

    def load(self, state: dict[str, np.ndarray]) -> None:
        """Take the weights of `state()`; raises ValueError that names what is missing,
        unknown or of another shape."""
        mine = self.named()
        if wrong := sorted(set(state) ^ set(mine)):
            raise ValueError(
                f"weights {', '.join(wrong)}: missing or unknown; this brain has {', '.join(mine)}"
            )
        for name, weights in mine.items():
            if np.shape(state[name]) != weights.shape:
                raise ValueError(
                    f"{name} has shape {np.shape(state[name])}; this brain needs {weights.shape}"
                )
        for name, weights in mine.items():
            weights[...] = state[name]

    def forward(self, observations: np.ndarray, split: Split | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return logits f32[n, sum(groups)] and values f32[n] of f32[n, n_observations].

        A row's bits depend neither on the other rows, nor on its place among them,
        nor on the threads of `split`.
        """
        n = len(observations)
        shape = observations.shape if type(observations) is np.ndarray else np.shape(observations)
        if shape != (n, self.n_observations):
            raise ValueError(f"observations have shape {shape}; allowed is (n, {self.n_observations})")
        x = np.asarray(observations, np.float32).T
        if not x.flags.forc:
            x = np.ascontiguousarray(x)
        logits, values = np.empty((n, self.n_logits), np.float32), np.empty(n, np.float32)
        arguments = x, self.weights, self.layers, logits, values
        if split is None:
            infer_shared(0, n, *arguments)
        else:
            split(infer_shared, n, *arguments, work=n * self.size // 800)
        return logits, values

    def recall(
        self, observations: np.ndarray, memory: np.ndarray, split: Split | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return what `forward` does, and the memory f32[n, 0] as it is."""
        return *self.forward(observations, split), memory

    def _draw(self, seed: int) -> None:
        """Draw all weights anew; biases are zero."""
        matrices = [(name, w) for name, w in self.named().items() if name.endswith("weight")]
        generators = [np.random.Generator(np.random.Philox(key=[seed, n])) for n in range(len(matrices))]
        with nullcontext() if portable.on() else one_blas_thread():
            drawn = [_orthogonal(g, *w.shape) for g, (_, w) in zip(generators, matrices, strict=True)]
        for (name, weights), matrix in zip(matrices, drawn, strict=True):
            weights[...] = {"policy.head.weight": 0.01, "value.head.weight": 1.0}.get(name, 2**0.5) * matrix
            if name == "policy.head.weight":
                weights[self.spreads] = 0


def _orthogonal(generator: np.random.Generator, n_out: int, n_in: int) -> np.ndarray:
    """Return a random f64[n_out, n_in] with orthonormal rows or columns,
    whichever are fewer (Saxe et al. 2014)."""
    if portable.on():
        return orthogonal(generator, n_out, n_in)
    q, r = np.linalg.qr(generator.standard_normal((max(n_out, n_in), min(n_out, n_in))))
    q *= np.sign(np.diag(r))
    return q if n_out >= n_in else q.T
