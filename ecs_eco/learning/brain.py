"""Brain: an actor-critic network of small tanh layers, with its backward pass written by hand.

A layer's product is one torch call into a buffer that exists already; everything between the products is a numba
kernel. Autograd spends most of its time on launching, on new tensors and on tanh (benchmarks/ppo.py has the ratio).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecs_eco.engine.threads import in_parallel, one_blas_thread
from ecs_eco.learning.arithmetic import fused_njit, tanh

if TYPE_CHECKING:
    import torch

CHUNK = 2048  # rows that go through the network at once: fixed, so that sums do not depend on the number of workers
FEWEST = 16  # rows: for less than 12, matrix products take another way, with other last bits


class Layer(NamedTuple):
    """Weights, or their gradient, of one layer: hidden layers are (in, out), heads (out, in), as each is fastest."""

    matrix: torch.Tensor
    bias: torch.Tensor
    bias_numpy: np.ndarray


class Brain:
    """A policy with one categorical choice per action group, and a value, over the same observations.

    `trunk` is "shared" (policy and value read the same hidden layers) or "separate" (each has its own).
    Weights are orthogonal, drawn from Philox keyed by (seed, layer), with gain sqrt(2); 0.01 for the policy's head and
    1 for the value's.
    """

    def __init__(
        self,
        n_observations: int,
        groups: tuple[int, ...],
        hidden: tuple[int, ...] = (64, 64),
        seed: int = 0,
        trunk: str = "shared",
    ) -> None:
        import torch

        _check(n_observations, groups, hidden, trunk)
        self.n_observations, self.groups, self.hidden, self.trunk = n_observations, tuple(groups), tuple(hidden), trunk
        self.offsets = np.cumsum((0, *groups)).astype(np.int64)  # group g's logits are offsets[g]:offsets[g + 1]
        self.n_logits = int(self.offsets[-1])
        heads = (self.n_logits + 1,) if trunk == "shared" else (self.n_logits, 1)
        self.towers = [list(zip((n_observations, *hidden), (*hidden, head), strict=True)) for head in heads]
        self.size = sum(_padded(a * b) + _padded(b) for tower in self.towers for a, b in tower)
        self.weights = torch.zeros(self.size)  # all of them in one row: to an optimiser they are one vector
        self.layers = self.views(self.weights)
        self._rows: list[dict[int, _Rows]] = []  # of each worker, by number of rows
        self._draw(seed)

    def views(self, row: torch.Tensor) -> list[list[Layer]]:
        """Return the layers of each tower as views of a row of `size` numbers: the weights, or a gradient."""
        at, towers = 0, []
        for tower in self.towers:
            layers: list[Layer] = []
            for a, b in tower:
                head = len(layers) == len(tower) - 1
                matrix = row[at : at + a * b].view((b, a) if head else (a, b))
                at += _padded(a * b)
                bias = row[at : at + b].view((b, 1) if head else (b,))
                layers.append(Layer(matrix, bias, bias.numpy()))
                at += _padded(b)
            towers.append(layers)
        return towers

    def named(self) -> dict[str, torch.Tensor]:
        """Return views of the weights by name, in torch's convention: weight (out, in), bias (out)."""
        names, n = {}, self.n_logits
        towers = ("trunk",) if self.trunk == "shared" else ("policy", "value")
        for layers, name in zip(self.layers, towers, strict=True):
            for level, layer in enumerate(layers[:-1]):
                names[f"{name}.{level}.weight"], names[f"{name}.{level}.bias"] = layer.matrix.t(), layer.bias
            parts = {"policy": slice(0, n), "value": slice(n, n + 1)} if name == "trunk" else {name: slice(None)}
            for part, rows in parts.items():
                names[f"{part}.head.weight"] = layers[-1].matrix[rows]
                names[f"{part}.head.bias"] = layers[-1].bias[rows, 0]
        return names

    def state(self) -> dict[str, np.ndarray]:
        """Return a copy of the weights by name."""
        return {name: np.array(tensor.numpy(), order="C") for name, tensor in self.named().items()}

    def load(self, state: dict[str, np.ndarray]) -> None:
        """Take the weights of `state()`; raises ValueError that names what is missing, unknown or of another shape."""
        mine = self.named()
        if wrong := sorted(set(state) ^ set(mine)):
            raise ValueError(f"weights {', '.join(wrong)}: missing or unknown; this brain has {', '.join(mine)}")
        for name, tensor in mine.items():
            if np.shape(state[name]) != tuple(tensor.shape):
                raise ValueError(f"{name} has shape {np.shape(state[name])}; this brain needs {tuple(tensor.shape)}")
        for name, tensor in mine.items():
            tensor.numpy()[...] = state[name]

    def forward(self, observations: np.ndarray, workers: int = 1) -> tuple[np.ndarray, np.ndarray]:
        """Return logits f32[n, sum(groups)] and values f32[n] of f32[n, n_observations].

        A row's bits depend neither on the other rows, nor on its place among them, nor on the number of `workers`.
        """
        n = len(observations)
        if np.shape(observations) != (n, self.n_observations):
            raise ValueError(f"observations have shape {np.shape(observations)}; allowed is (n, {self.n_observations})")
        logits, values = np.empty((n, self.n_logits), np.float32), np.empty(n, np.float32)

        def work(worker: int) -> None:
            for start in range(worker * CHUNK, n, workers * CHUNK):
                stop = min(start + CHUNK, n)
                rows = self.rows(worker, max(FEWEST, stop - start))
                rows.observations[: stop - start] = observations[start:stop]
                self.run(rows)
                logits[start:stop], values[start:stop] = rows.logits[:, : stop - start].T, rows.values[: stop - start]

        in_parallel(work, workers)
        return logits, values

    def rows(self, worker: int, n: int) -> _Rows:
        """Return the buffers of a worker for n <= CHUNK rows; what they held for another n is lost."""
        while len(self._rows) <= worker:
            self._rows.append({CHUNK: _Rows(self, CHUNK)})
        kept = self._rows[worker]
        if n not in kept:
            if len(kept) > 4:
                kept.pop(next(size for size in kept if size != CHUNK))
            kept[n] = _Rows(self, n, kept[CHUNK])
        return kept[n]

    def run(self, rows: _Rows) -> None:
        """Fill the activations, logits and values of `rows` from its observations."""
        import torch

        for layers, levels, out in zip(self.layers, rows.towers, rows.outs, strict=True):
            below = rows.x
            for layer, level in zip(layers, levels, strict=False):
                torch.addmm(layer.bias, below, layer.matrix, out=level.h)
                _tanh_all(level.h_numpy)
                below = level.h
            torch.addmm(layers[-1].bias, layers[-1].matrix, below.t(), out=out)

    def back(self, rows: _Rows, gradient: list[list[Layer]]) -> None:
        """Turn the slopes of the loss in `rows.d_logits` and `rows.d_values` into the gradient of every weight."""
        import torch

        for layers, into, levels, d_out in zip(self.layers, gradient, rows.towers, rows.d_outs, strict=True):
            d, matrix = d_out.t(), layers[-1].matrix
            torch.mm(d_out, levels[-1].h, out=into[-1].matrix)
            torch.sum(d_out, 1, keepdim=True, out=into[-1].bias)
            for i in range(len(levels) - 1, -1, -1):
                level = levels[i]
                torch.mm(d, matrix, out=level.d)
                _through_tanh(level.d_numpy, level.h_numpy, into[i].bias_numpy)
                torch.mm((levels[i - 1].h if i else rows.x).t(), level.d, out=into[i].matrix)
                d, matrix = level.d, layers[i].matrix.t()

    def _draw(self, seed: int) -> None:
        """Draw all weights anew; biases are zero."""
        matrices = ((name, t) for name, t in self.named().items() if name.endswith("weight"))
        for number, (name, tensor) in enumerate(matrices):
            gain = {"policy.head.weight": 0.01, "value.head.weight": 1.0}.get(name, 2**0.5)
            generator = np.random.Generator(np.random.Philox(key=[seed, number]))
            tensor.numpy()[...] = gain * _orthogonal(generator, *tensor.shape)


class _Level(NamedTuple):
    """Activations h of one hidden layer and the slopes d of the loss, f32[n, width], as torch and numpy see them."""

    h: torch.Tensor
    h_numpy: np.ndarray
    d: torch.Tensor
    d_numpy: np.ndarray


class _Rows:
    """The buffers of n rows on their way through the network; outputs are (out, n), so that kernels run along the rows.

    With `whole`, they are views of another's memory.
    """

    def __init__(self, brain: Brain, n: int, whole: _Rows | None = None) -> None:
        import torch

        self.memory: list[torch.Tensor] = whole.memory if whole else []
        slot = iter(range(len(self.memory)))

        def buffer(*shape: int) -> torch.Tensor:
            if not whole:
                self.memory.append(torch.zeros(shape).view(-1))
            return self.memory[next(slot) if whole else -1][: shape[0] * shape[1]].view(shape)

        def level(width: int) -> _Level:
            h, d = buffer(n, width), buffer(n, width)
            return _Level(h, h.numpy(), d, d.numpy())

        self.x = buffer(n, brain.n_observations)
        self.observations = self.x.numpy()
        self.towers = [[level(width) for _, width in tower[:-1]] for tower in brain.towers]
        self.outs = [buffer(tower[-1][1], n) for tower in brain.towers]
        self.d_outs = [buffer(tower[-1][1], n) for tower in brain.towers]
        k = brain.n_logits
        self.logits, self.d_logits = self.outs[0].numpy()[:k], self.d_outs[0].numpy()[:k]
        self.values, self.d_values = self.outs[-1].numpy()[-1], self.d_outs[-1].numpy()[-1]


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


def _padded(n: int) -> int:
    """Return n up to a multiple of 16 floats, 64 bytes, where vector loads are fastest."""
    return -(-n // 16) * 16


def _orthogonal(generator: np.random.Generator, n_out: int, n_in: int) -> np.ndarray:
    """Return a random f64[n_out, n_in] with orthonormal rows or columns, whichever are fewer (Saxe et al. 2014)."""
    with one_blas_thread():
        q, r = np.linalg.qr(generator.standard_normal((max(n_out, n_in), min(n_out, n_in))))
    q *= np.sign(np.diag(r))
    return q if n_out >= n_in else q.T


def _check(n_observations: int, groups: tuple[int, ...], hidden: tuple[int, ...], trunk: str) -> None:
    if n_observations < 1:
        raise ValueError(f"n_observations = {n_observations}: allowed is a whole number >= 1")
    if not groups or min(groups) < 1:
        raise ValueError(f"groups = {groups}: allowed is a tuple of one or more sizes >= 1, one per action group")
    if not hidden or min(hidden) < 1:
        raise ValueError(f"hidden = {hidden}: allowed is a tuple of one or more layer widths >= 1")
    if trunk not in ("shared", "separate"):
        raise ValueError(f"trunk = {trunk!r}: allowed is 'shared' or 'separate'")
