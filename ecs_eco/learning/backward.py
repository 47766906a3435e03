"""The pass of a brain there and back again, as learning needs it: activations are kept,
and turned into a gradient by hand.

A layer's product is one torch call into a buffer that exists already; everything between the products is a
numba kernel. Autograd spends most of its time on launching, on new tensors and on tanh (benchmarks/ppo.py has
the ratio).
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import numpy as np
import torch

from ecs_eco.engine import portable
from ecs_eco.learning.arithmetic import fused_njit, tanh
from ecs_eco.learning.brain import Brain
from ecs_eco.learning.brain import Layer as BrainLayer

# rows that go through the network at once: fixed, so that sums do not depend on the number of workers
CHUNK = 2048

_addmm: Any = torch.addmm
_mm: Any = torch.mm
_row_sums: Any = partial(torch.sum, dim=1, keepdim=True)
if portable.on():
    from ecs_eco.learning.products import addmm as _addmm
    from ecs_eco.learning.products import mm as _mm
    from ecs_eco.learning.products import row_sums as _row_sums


class Layer(NamedTuple):
    """Weights, or their gradient, of one layer, as torch sees them: the bias is (b,), that of a head (b, 1);
    `turned` is the matrix transposed, made once, as a view costs as much as a small product.
    """

    matrix: torch.Tensor
    turned: torch.Tensor
    bias: torch.Tensor
    bias_numpy: np.ndarray


Towers = list[list[Layer]]


class Passes:
    """The passes of one brain, and the buffers of each worker's rows."""

    def __init__(self, brain: Brain) -> None:
        self.brain = brain
        self.layers = self.views(brain.weights)
        self._rows: list[dict[int, Rows]] = []  # of each worker, by number of rows

    def views(self, row: np.ndarray) -> Towers:
        """Return the layers of each tower as torch's views of a row of the brain's `size` numbers."""
        return [[_as_torch(layer, head=layer is tower[-1]) for layer in tower]
                for tower in self.brain.views(row)]

    def rows(self, worker: int, n: int) -> Rows:
        """Return the buffers of a worker for n <= CHUNK rows; what they held for another n is lost."""
        while len(self._rows) <= worker:
            self._rows.append({CHUNK: Rows(self.brain, CHUNK)})
        kept = self._rows[worker]
        if n not in kept:
            if len(kept) > 4:
                kept.pop(next(size for size in kept if size != CHUNK))
            kept[n] = Rows(self.brain, n, kept[CHUNK])
        return kept[n]

    def run(self, rows: Rows) -> None:
        """Fill the activations, logits and values of `rows` from its observations."""
        for layers, levels, out in zip(self.layers, rows.towers, rows.outs, strict=True):
            below = rows.x
            for layer, level in zip(layers, levels, strict=False):
                _addmm(layer.bias, below, layer.matrix, out=level.h)
                _tanh_all(level.h_numpy)
                below = level.h
            _addmm(layers[-1].bias, layers[-1].matrix, levels[-1].h_turned if levels else rows.x_turned,
                   out=out)

    def back(self, rows: Rows, gradient: Towers) -> None:
        """Turn the slopes of the loss in `rows.d_logits` and `rows.d_values` into the gradient
        of every weight."""
        for layers, into, levels, (d_out, d) in zip(self.layers, gradient, rows.towers, rows.d_outs,
                                                    strict=True):
            matrix = layers[-1].matrix
            _mm(d_out, levels[-1].h, out=into[-1].matrix)
            _row_sums(d_out, out=into[-1].bias)
            for i in range(len(levels) - 1, -1, -1):
                level = levels[i]
                _mm(d, matrix, out=level.d)
                _through_tanh(level.d_numpy, level.h_numpy, into[i].bias_numpy)
                _mm(levels[i - 1].h_turned if i else rows.x_turned, level.d, out=into[i].matrix)
                d, matrix = level.d, layers[i].turned


def _as_torch(layer: BrainLayer, head: bool) -> Layer:
    matrix, bias = torch.from_numpy(layer.matrix), torch.from_numpy(layer.bias)
    return Layer(matrix, matrix.t(), bias[:, None] if head else bias, layer.bias)


class _Level(NamedTuple):
    """Activations h of one hidden layer and the slopes d of the loss, f32[n, width],
    as torch and numpy see them; `h_turned` is h transposed."""

    h: torch.Tensor
    h_turned: torch.Tensor
    h_numpy: np.ndarray
    d: torch.Tensor
    d_numpy: np.ndarray


class Rows:
    """The buffers of n rows on their way through the network; outputs are (out, n),
    so that kernels run along the rows.

    With `whole`, they are views of another's memory.
    """

    def __init__(self, brain: Brain, n: int, whole: Rows | None = None) -> None:
        self.memory: list[torch.Tensor] = whole.memory if whole else []
        slot = iter(range(len(self.memory)))

        def buffer(*shape: int) -> torch.Tensor:
            if not whole:
                self.memory.append(torch.zeros(shape).view(-1))
            return self.memory[next(slot) if whole else -1][: shape[0] * shape[1]].view(shape)

        def level(width: int) -> _Level:
            h, d = buffer(n, width), buffer(n, width)
            return _Level(h, h.t(), h.numpy(), d, d.numpy())

        self.x = buffer(n, brain.n_observations)
        self.x_turned, self.observations = self.x.t(), self.x.numpy()
        self.towers = [[level(width) for _, width in tower[:-1]] for tower in brain.towers]
        self.outs = [buffer(tower[-1][1], n) for tower in brain.towers]
        d_outs = [buffer(tower[-1][1], n) for tower in brain.towers]
        self.d_outs = [(d_out, d_out.t()) for d_out in d_outs]
        k = brain.n_logits
        self.logits, self.d_logits = self.outs[0].numpy()[:k], d_outs[0].numpy()[:k]
        self.values, self.d_values = self.outs[-1].numpy()[-1], d_outs[-1].numpy()[-1]


@fused_njit
def _tanh_all(h):
    """Replace h by tanh(h)."""
    flat = h.reshape(h.size)
    for i in range(flat.size):
        flat[i] = tanh(flat[i])


@fused_njit
def _through_tanh(d, h, d_bias):
    """Turn slopes by h = tanh(a) into slopes by a, and sum them over the rows."""
    d_bias[:] = 0
    for i in range(d.shape[0]):
        for j in range(d.shape[1]):
            d[i, j] *= np.float32(1) - h[i, j] * h[i, j]
        for j in range(d.shape[1]):
            d_bias[j] += d[i, j]


