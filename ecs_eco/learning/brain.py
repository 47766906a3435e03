"""Brain: an actor-critic network of small tanh layers.

It thinks without torch; how it learns is in backward.py and ppo.py.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from typing import NamedTuple

import numpy as np

from ecs_eco.engine import portable
from ecs_eco.engine.threads import one_blas_thread
from ecs_eco.learning.continuous import laid_out, spreads
from ecs_eco.learning.inference import infer
from ecs_eco.learning.orthogonal import orthogonal
from ecs_eco.learning.policy_network import Split


class Layer(NamedTuple):
    """Weights, or their gradient, of one layer: hidden layers are (in, out), heads (out, in),
    as each is fastest."""

    matrix: np.ndarray
    bias: np.ndarray


class Brain:
    """A policy with a choice per action group, and a value, over the same observations.

    `groups` are the numbers of options of the categorical ones, then CONTINUOUS for each continuous one.

    `trunk` is "shared" (policy and value read the same hidden layers) or "separate" (each has its own).
    Weights are orthogonal, drawn from Philox keyed by (seed, layer), with gain sqrt(2); 0.01 for the policy's
    head and 1 for the value's.
    """

    memory = 0  # numbers that it keeps from one decision to the next
    by_row = True

    def __init__(
        self,
        n_observations: int,
        groups: tuple[int, ...],
        hidden: tuple[int, ...] = (64, 64),
        seed: int = 0,
        trunk: str = "shared",
    ) -> None:
        _check(n_observations, groups, hidden, trunk)
        self.n_observations, self.groups, self.hidden, self.trunk = (
            n_observations,
            tuple(groups),
            tuple(hidden),
            trunk,
        )
        # categorical group g's logits are offsets[g]:offsets[g + 1]; then come means and spreads
        self.offsets, self.n_numbers = laid_out(groups)
        self.n_logits, self.spreads = sum(groups), spreads(groups)
        heads = (self.n_logits + 1,) if trunk == "shared" else (self.n_logits, 1)
        self.towers = [list(zip((n_observations, *hidden), (*hidden, head), strict=True)) for head in heads]
        self.size = sum(padded(a * b) + padded(b) for tower in self.towers for a, b in tower)
        self.weights = _aligned(self.size)  # all of them in one row: to an optimiser they are one vector
        self.layers = self.views(self.weights)
        self._plans = list(self._plan())
        self._draw(seed)

    def views(self, row: np.ndarray) -> list[list[Layer]]:
        """Return the layers of each tower as views of a row of `size` numbers: the weights, or a gradient."""
        at, towers = 0, []
        for tower in self.towers:
            layers: list[Layer] = []
            for a, b in tower:
                head = len(layers) == len(tower) - 1
                matrix = row[at : at + a * b].reshape((b, a) if head else (a, b))
                at += padded(a * b)
                layers.append(Layer(matrix, row[at : at + b]))
                at += padded(b)
            towers.append(layers)
        return towers

    def named(self) -> dict[str, np.ndarray]:
        """Return views of the weights by name, in torch's convention: weight (out, in), bias (out)."""
        names, n = {}, self.n_logits
        towers = ("trunk",) if self.trunk == "shared" else ("policy", "value")
        for layers, name in zip(self.layers, towers, strict=True):
            for level, layer in enumerate(layers[:-1]):
                names[f"{name}.{level}.weight"], names[f"{name}.{level}.bias"] = layer.matrix.T, layer.bias
            parts = (
                {"policy": slice(0, n), "value": slice(n, n + 1)} if name == "trunk" else {name: slice(None)}
            )
            for part, rows in parts.items():
                names[f"{part}.head.weight"] = layers[-1].matrix[rows]
                names[f"{part}.head.bias"] = layers[-1].bias[rows]
        return names

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
        outputs = (logits,) if len(self._plans) == 1 else (logits, logits[:, :0].copy())
        for out, (widths, starts) in zip(outputs, self._plans, strict=True):
            if split is None:
                infer(0, n, x, self.weights, widths, starts, out, values)
            else:
                split(infer, n, x, self.weights, widths, starts, out, values, work=n * self.size // 800)
        return logits, values

    def recall(
        self, observations: np.ndarray, memory: np.ndarray, split: Split | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return what `forward` does, and the memory f32[n, 0] as it is."""
        return *self.forward(observations, split), memory

    def _plan(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield, for each tower, the widths of its layers and where each matrix and bias begins."""
        at = 0
        for tower in self.towers:
            starts = []
            for a, b in tower:
                starts += [at, at + padded(a * b)]
                at += padded(a * b) + padded(b)
            yield np.array([tower[0][0], *(b for _, b in tower)]), np.array(starts)

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


def _aligned(n: int) -> np.ndarray:
    """Return zeros f32[n] that begin at a multiple of 64 bytes, where vector loads are fastest."""
    room = np.zeros(n + 16, np.float32)
    skip = -room.ctypes.data % 64 // 4
    return room[skip : skip + n]


def padded(n: int) -> int:
    """Return n up to a multiple of 16 floats, 64 bytes, where vector loads are fastest."""
    return -(-n // 16) * 16


def _orthogonal(generator: np.random.Generator, n_out: int, n_in: int) -> np.ndarray:
    """Return a random f64[n_out, n_in] with orthonormal rows or columns,
    whichever are fewer (Saxe et al. 2014)."""
    if portable.on():
        return orthogonal(generator, n_out, n_in)
    q, r = np.linalg.qr(generator.standard_normal((max(n_out, n_in), min(n_out, n_in))))
    q *= np.sign(np.diag(r))
    return q if n_out >= n_in else q.T


def _check(n_observations: int, groups: tuple[int, ...], hidden: tuple[int, ...], trunk: str) -> None:
    if n_observations < 1:
        raise ValueError(f"n_observations = {n_observations}: allowed is a whole number >= 1")
    if not groups or min(groups) < 1:
        raise ValueError(
            f"groups = {groups}: allowed is a tuple of one or more sizes >= 1, one per action group"
        )
    if not hidden or min(hidden) < 1:
        raise ValueError(f"hidden = {hidden}: allowed is a tuple of one or more layer widths >= 1")
    if trunk not in ("shared", "separate"):
        raise ValueError(f"trunk = {trunk!r}: allowed is 'shared' or 'separate'")
