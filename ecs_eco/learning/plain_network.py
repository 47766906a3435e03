"""The shape of a plain network: tanh layers, then heads for policy and value; and where its weights lie."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from ecs_eco.compiled.vectors import LANES
from ecs_eco.learning.continuous import laid_out, spreads

LAYER = np.dtype(
    (
        np.record,  # fields are attributes, also where kernels are not compiled
        [
            ("inputs", "i8"),
            ("outputs", "i8"),
            ("weights", "i8"),  # where its matrix (inputs, outputs) begins in a row of weights; then its bias
            ("transposed", "i8"),  # and among those transposed, whose rows are up to a multiple of LANES
            (
                "below",
                "i8",
            ),  # where the activations that it reads begin [numbers per transition]; 0: observed
            ("above", "i8"),  # and its own
            ("hidden", "i8"),  # whether tanh is taken of them
        ],
    )
)


class PlainNetwork:
    """The shape of a policy with a choice per action group, and a value, over the same observations.

    `groups` are the numbers of options of the categorical ones, then CONTINUOUS for each continuous one.
    `trunk` is "shared" (policy and value read the same hidden layers) or "separate" (each has its own). A
    network is one row of `size` numbers: of each layer the matrix (in, out), then the bias. With a shared
    trunk the last layer has all outputs of the policy, then the value; else the policy's layers come first.
    """

    memory = 0  # numbers that it keeps from one decision to the next
    by_row = True  # what one thinks depends on no other, to the bit: processes may share the rows

    def __init__(
        self, n_observations: int, groups: tuple[int, ...], hidden: tuple[int, ...], trunk: str = "shared"
    ) -> None:
        if n_observations < 1:
            raise ValueError(f"n_observations = {n_observations}: allowed is a whole number >= 1")
        if not groups or min(groups) < 1:
            raise ValueError(
                f"groups = {groups}: allowed is a tuple of one or more sizes >= 1, one per action group"
            )
        if min(hidden, default=1) < 1:
            raise ValueError(f"hidden = {hidden}: allowed is a tuple of layer widths >= 1, or ()")
        if trunk not in ("shared", "separate"):
            raise ValueError(f"trunk = {trunk!r}: allowed is 'shared' or 'separate'")
        self.n_observations, self.groups = n_observations, tuple(groups)
        self.hidden, self.trunk = tuple(hidden), trunk
        # categorical group g's logits are offsets[g]:offsets[g + 1]; then come means and spreads
        self.offsets, self.n_numbers = laid_out(groups)
        self.n_logits, self.spreads = sum(groups), spreads(groups)
        heads = (self.n_logits + 1,) if trunk == "shared" else (self.n_logits, 1)
        self.towers = [list(pairwise((n_observations, *hidden, head))) for head in heads]
        self.shapes: list[tuple[int, ...]] = [
            shape for tower in self.towers for a, b in tower for shape in ((a, b), (b,))
        ]
        self.layers = np.array(list(self._layers()), LAYER)
        self.size = sum(a * b + b for tower in self.towers for a, b in tower)

    def _layers(self) -> Iterator[tuple[int, ...]]:
        """Yield the layout of each layer, tower by tower."""
        weights = transposed = 0
        above = _whole(self.n_observations)
        for tower in self.towers:
            below = 0
            for level, (a, b) in enumerate(tower):
                yield a, b, weights, transposed, below, above, level < len(tower) - 1
                weights += (a + 1) * b
                transposed += b * _whole(a) if level else 0
                below, above = above, above + _whole(b)

    def views(self, weights: np.ndarray) -> list[np.ndarray]:
        """Return the parts of weights [..., size] in the order of `shapes`;
        the value is the last output of the last layer."""
        ends = np.cumsum([int(np.prod(shape)) for shape in self.shapes])
        parts = np.split(weights, ends[:-1], axis=-1)
        return [
            part.reshape(*weights.shape[:-1], *shape) for part, shape in zip(parts, self.shapes, strict=True)
        ]

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


def _whole(n: int) -> int:
    """Return n up to a whole number of vectors."""
    return -(-n // LANES) * LANES
