"""Plain actor-critic networks of small tanh layers: their shape, the layout of their weights, and `Brain`,
which all members of a species share.

Inference needs no torch; learning is in ppo.py.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from itertools import pairwise
from typing import Any

import numpy as np

from ecs_eco.compiled import portable
from ecs_eco.compiled.elementary import arrays
from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.threads import one_blas_thread
from ecs_eco.compiled.vectors import LANES
from ecs_eco.learning.continuous import laid_out, spreads
from ecs_eco.learning.inference import infer_shared
from ecs_eco.learning.layers import Layer
from ecs_eco.learning.policy_network import PolicyNetwork, Split


class PlainNetwork:
    """The shape of a network that computes one choice per action group (the policy) and a value.

    `groups` contains the number of options of each categorical group, then CONTINUOUS for each continuous
    one. `trunk` is "shared" (policy and value read the same hidden layers) or "separate" (each has its own).
    A network is one row of `size` numbers: for each layer, the matrix (in, out), then the bias. With a shared
    trunk, the last layer has all outputs of the policy, then the value; otherwise the policy's layers come
    first.
    """

    memory = 0  # number of values kept between decisions
    by_row = True  # rows are independent, bit for bit, so processes can share them

    def __init__(
        self, n_observations: int, groups: tuple[int, ...], hidden: tuple[int, ...], trunk: str = "shared"
    ) -> None:
        if n_observations < 1:
            raise ValueError(f"n_observations = {n_observations}: expected a whole number >= 1")
        if not groups or min(groups) < 1:
            raise ValueError(
                f"groups = {groups}: expected a tuple of one or more sizes >= 1, one per action group"
            )
        if min(hidden, default=1) < 1:
            raise ValueError(f"hidden = {hidden}: expected a tuple of layer widths >= 1, or ()")
        if trunk not in ("shared", "separate"):
            raise ValueError(f"trunk = {trunk!r}: expected 'shared' or 'separate'")
        self.n_observations, self.groups = n_observations, tuple(groups)
        self.hidden, self.trunk = tuple(hidden), trunk
        # categorical group g's logits are offsets[g]:offsets[g + 1], followed by means and log standard
        # deviations
        self.offsets, self.n_numbers = laid_out(groups)
        self.n_logits, self.spreads = sum(groups), spreads(groups)
        heads = (self.n_logits + 1,) if trunk == "shared" else (self.n_logits, 1)
        self.towers = [list(pairwise((n_observations, *hidden, head))) for head in heads]
        self.shapes: list[tuple[int, ...]] = [
            shape for tower in self.towers for a, b in tower for shape in ((a, b), (b,))
        ]
        self.layers = np.array(list(self._layers()), np.int64)
        self.size = sum(a * b + b for tower in self.towers for a, b in tower)

    def _layers(self) -> Iterator[Layer]:
        """Yield the layout of each layer, tower by tower."""
        weights = transposed = 0
        above = _whole(self.n_observations)
        for tower in self.towers:
            below = 0
            for level, (a, b) in enumerate(tower):
                yield Layer(a, b, weights, transposed, below, above, level < len(tower) - 1)
                weights += (a + 1) * b
                transposed += b * _whole(a) if level else 0
                below, above = above, above + _whole(b)

    def views(self, weights: np.ndarray) -> list[np.ndarray]:
        """Split weights [..., size] into parts in the same order as `shapes`; the value is the last output of
        the last layer."""
        ends = np.cumsum([int(np.prod(shape)) for shape in self.shapes])
        parts = np.split(weights, ends[:-1], axis=-1)
        return [
            part.reshape(*weights.shape[:-1], *shape) for part, shape in zip(parts, self.shapes, strict=True)
        ]

    def module(self, weights: np.ndarray) -> Any:
        """Return a network with weights f32[size] as an independent torch module."""
        import torch

        from ecs_eco.learning.mlp import MLP

        module = MLP(self.n_observations, self.groups, self.hidden, self.trunk)
        named = self.named_views(weights)
        module.load_state_dict({name: torch.from_numpy(part.copy()) for name, part in named.items()})
        return module.eval()

    def named_views(self, weights: np.ndarray) -> dict[str, np.ndarray]:
        """Return views of weights f32[size] by name, in torch's convention: weight (out, in), bias (out)."""
        names, parts, n = {}, iter(self.views(weights)), self.n_logits
        for name in ("trunk",) if self.trunk == "shared" else ("policy", "value"):
            for level in range(len(self.hidden)):
                names[f"{name}.{level}.weight"], names[f"{name}.{level}.bias"] = next(parts).T, next(parts)
            matrix, bias = next(parts), next(parts)
            heads = (
                {"policy": slice(0, n), "value": slice(n, n + 1)} if name == "trunk" else {name: slice(None)}
            )
            for head, outputs in heads.items():
                names[f"{head}.head.weight"] = matrix[:, outputs].T
                names[f"{head}.head.bias"] = bias[outputs]
        return names


class Brain(PlainNetwork, PolicyNetwork):
    """The built-in actor-critic network, which outputs one choice per action group and a value.

    Parameters
    ----------
    n_observations : int
    groups : tuple of int
        Number of options of each categorical group, then `CONTINUOUS` for each continuous one.
    hidden : tuple of int, default (64, 64)
        Number of units in each hidden layer.
    seed : int, default 0
        Random seed for the initial weights.
    trunk : {"shared", "separate"}
        Whether policy and value share the hidden layers.

    Notes
    -----
    Weights are orthogonal (Saxe et al. 2014), drawn from Philox keyed by (seed, layer). The gain is 0.01 for
    the policy head, 1 for the value head and sqrt(2) elsewhere.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.learning import Brain
    >>> brain = Brain(3, groups=(2, 4), seed=1)
    >>> logits, values = brain.forward(np.zeros((5, 3), np.float32))
    >>> logits.shape, values.shape
    ((5, 6), (5,))
    >>> brain.load(Brain(3, groups=(2, 4), seed=2).state())
    >>> len(brain.named()) == len(brain.state())
    True
    """

    called = "brain"

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
            raise ValueError(f"hidden = {hidden}: expected a tuple of one or more layer widths >= 1")
        self.weights = np.zeros(self.size, np.float32)
        self._draw(seed)

    def named(self) -> dict[str, np.ndarray]:
        """Return views of the weights by name.

        Returns
        -------
        dict of str to array of float32
            Shaped as in torch: weight (out, in), bias (out).
        """
        return self.named_views(self.weights)

    def recall(
        self, observations: np.ndarray, memory: np.ndarray, split: Split | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the result of `forward`, and the memory f32[n, 0] unchanged. A row's results are
        bit-identical regardless of the other rows and the number of threads."""
        n = self._rows(observations)
        x = np.asarray(observations, np.float32).T
        if not x.flags.forc:
            x = np.ascontiguousarray(x)
        logits, values = np.empty((n, self.n_logits), np.float32), np.empty(n, np.float32)
        arguments = x, self.weights, self.layers, logits, values
        if split is None:
            infer_shared(0, n, *arguments)
        else:
            split(infer_shared, n, *arguments, work=n * self.size // 800)
        return logits, values, memory

    def _draw(self, seed: int) -> None:
        """Redraw all weights; biases are zero."""
        matrices = [(name, w) for name, w in self.named().items() if name.endswith("weight")]
        generators = [np.random.Generator(np.random.Philox(key=[seed, n])) for n in range(len(matrices))]
        with nullcontext() if portable.on() else one_blas_thread():
            drawn = [orthogonal(g, *w.shape) for g, (_, w) in zip(generators, matrices, strict=True)]
        for (name, weights), matrix in zip(matrices, drawn, strict=True):
            weights[...] = {"policy.head.weight": 0.01, "value.head.weight": 1.0}.get(name, 2**0.5) * matrix
            if name == "policy.head.weight":
                weights[self.spreads] = 0


def orthogonal(generator: np.random.Generator, n_out: int, n_in: int) -> np.ndarray:
    """Return a random f64[n_out, n_in] with orthonormal rows or columns, whichever are fewer (Saxe et al.
    2014)."""
    if not portable.on():
        q, r = np.linalg.qr(generator.standard_normal((max(n_out, n_in), min(n_out, n_in))))
        q *= np.sign(np.diag(r))
        return q if n_out >= n_in else q.T
    # in libraries, the order of summation depends on the processor
    columns = normals(generator, (min(n_out, n_in), max(n_out, n_in)))
    _orthonormalise(columns)
    return columns.T if n_out >= n_in else columns


def normals(generator: np.random.Generator, shape: tuple[int, int]) -> np.ndarray:
    """Return normally distributed numbers, f64 of this shape (Box and Muller 1958)."""
    u, v = generator.random((2, *shape))
    numbers: np.ndarray = np.sqrt(-2.0 * arrays.log1p(-u)) * arrays.cos(2.0 * np.pi * v)
    return numbers


@njit
def _orthonormalise(vectors):
    """Orthonormalize the rows f64[k, n], each against all previous ones, twice (Giraud et al. 2005)."""
    for i in range(len(vectors)):
        for _ in range(2):
            for j in range(i):
                along = 0.0
                for c in range(vectors.shape[1]):
                    along += vectors[i, c] * vectors[j, c]
                for c in range(vectors.shape[1]):
                    vectors[i, c] -= along * vectors[j, c]
        length = 0.0
        for c in range(vectors.shape[1]):
            length += vectors[i, c] * vectors[i, c]
        vectors[i] /= np.sqrt(length)


def _whole(n: int) -> int:
    """Return n rounded up to a whole number of vectors."""
    return -(-n // LANES) * LANES
