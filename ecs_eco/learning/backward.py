"""The gradient of PPO's loss by the weights of a plain network: forward, the loss and backward in one kernel.

Transitions go through the network in blocks that stay in the cache. Everything lies (transitions, units),
with units filled up to whole vectors, so that all products have one form: rows of sums in registers.
Autograd takes three times as long (benchmarks/ppo.py).
"""

from __future__ import annotations

import numpy as np

from ecs_eco.engine.vectors import LANES, WIDE, every, load, store
from ecs_eco.learning.arithmetic import fused_njit, lone_fused_njit, tanh
from ecs_eco.learning.brain import Brain, padded
from ecs_eco.learning.ppo_kernels import loss_slopes

# transitions of one gradient: fixed, so that sums do not depend on the number of workers
CHUNK = 2048
BLOCK = 64  # transitions that go through the network at once
# columns of a plan
IN, OUT, WIDE_IN, WIDE_OUT, MATRIX, BIAS, FORTH, SHIFT, BACK, ABOVE, SLOPES = range(11)


class Passes:
    """The way of transitions through a brain and back, and what it needs of memory for each worker."""

    def __init__(self, brain: Brain) -> None:
        self.brain = brain
        self.plan, packed, rows = _plan(brain)
        self._packed = np.zeros(packed, np.float32)
        self._n_memory = rows * BLOCK
        self._workers: list[tuple[np.ndarray, np.ndarray]] = []  # memory, and sums of gradients

    def begin(self, workers: int) -> None:
        """Take over the brain's weights as they are now."""
        while len(self._workers) < workers:
            self._workers.append((np.zeros(self._n_memory, np.float32), np.zeros_like(self._packed)))
        _pack(self.brain.weights, self.plan, self._packed)

    def gradient(
        self,
        worker: int,
        index: np.ndarray,
        log: tuple[np.ndarray, ...],
        settings: np.ndarray,
        gradient: np.ndarray,
        terms: np.ndarray,
    ) -> None:
        """Write the gradient f32[brain.size] of the loss over transitions i64[n] of a log, and its terms.

        A log is the observations, choices, numbers and steps of a rollout; `settings` f32[7] are clip …
        share, as `loss_slopes` takes them.
        """
        _gradient(
            index,
            *log,
            self.brain.offsets,
            settings,
            self.plan,
            self._packed,
            *self._workers[worker],
            gradient,
            terms,
        )


def _plan(brain: Brain) -> tuple[np.ndarray, int, int]:
    """Return where everything lies, i64[towers, layers, 11], the size of packed weights, and how many numbers
    of memory each transition of a block takes."""
    plan = np.zeros((len(brain.towers), len(brain.towers[0]), 11), np.int64)
    at = packed = 0
    rows = _wide(brain.n_observations)  # the observations come first
    for tower, sizes in zip(plan, brain.towers, strict=True):
        for row, (a, b) in zip(tower, sizes, strict=True):
            wide = _wide(a), _wide(b)
            row[:BACK] = (a, b, *wide, at, at + padded(a * b), packed, packed + wide[0] * wide[1])
            row[ABOVE:] = rows * BLOCK, (rows + wide[1]) * BLOCK
            at += padded(a * b) + padded(b)
            packed += (wide[0] + 1) * wide[1]
            rows += 2 * wide[1]
    layers = plan.reshape(-1, 11)
    for row in layers:
        row[BACK] = packed
        packed += row[OUT] * row[WIDE_IN]
    return plan, packed + layers[:, WIDE_IN].max(), rows + 2 * (brain.n_logits + 1)


def _wide(n: int) -> int:
    """Return n up to a whole number of vectors."""
    return -(-n // LANES) * LANES


@fused_njit
def _pack(weights, plan, packed):
    """Write each layer's matrix (in, out), its bias and its matrix (out, in), in whole vectors;
    zeros follow."""
    for tower in plan:
        for level in range(len(tower)):
            layer = tower[level]
            n_in, n_out, matrix = layer[IN], layer[OUT], weights[layer[MATRIX] :]
            forth, back = packed[layer[FORTH] :], packed[layer[BACK] :]
            if level == len(tower) - 1:  # a head is (out, in)
                _lay_turned(matrix, n_in, forth, layer[WIDE_OUT], n_out, n_in)
                _lay(matrix, n_in, back, layer[WIDE_IN], n_out, n_in)
            else:
                _lay(matrix, n_out, forth, layer[WIDE_OUT], n_in, n_out)
                _lay_turned(matrix, n_out, back, layer[WIDE_IN], n_in, n_out)
            _lay(weights[layer[BIAS] :], n_out, packed[layer[SHIFT] :], n_out, 1, n_out)


@fused_njit
def _unpack(sums, plan, gradient):
    """Write sums, those of a head (out, in) and the others as packed weights lie, into a gradient that lies
    as the weights."""
    for tower in plan:
        for level in range(len(tower)):
            layer = tower[level]
            n_in, n_out, wide = layer[IN], layer[OUT], layer[WIDE_OUT]
            if level == len(tower) - 1:
                _lay(sums[layer[FORTH] :], layer[WIDE_IN], gradient[layer[MATRIX] :], n_in, n_out, n_in)
            else:
                _lay(sums[layer[FORTH] :], wide, gradient[layer[MATRIX] :], n_out, n_in, n_out)
            _lay(sums[layer[SHIFT] :], n_out, gradient[layer[BIAS] :], n_out, 1, n_out)


@lone_fused_njit
def _lay(a, a_row, out, out_row, rows, columns):
    """Copy a matrix whose rows are `a_row` apart to where they are `out_row` apart."""
    for r in range(rows):
        here, there = a[r * a_row : r * a_row + columns], out[r * out_row : r * out_row + columns]
        for c in range(columns):
            there[c] = here[c]


@lone_fused_njit
def _lay_turned(a, a_row, out, out_row, rows, columns):
    """Copy a matrix so that its columns become rows, `out_row` apart."""
    for r in range(rows):
        for c in range(columns):
            out[c * out_row + r] = a[r * a_row + c]


@fused_njit
def _gradient(
    index,
    observations,
    choices,
    numbers,
    steps,
    offsets,
    settings,
    plan,
    packed,
    memory,
    sums,
    gradient,
    terms,
):
    """Write the gradient of the loss over the transitions `index`, and the sums of its terms."""
    sums[:] = 0
    terms[:] = 0
    last, part, n_out = plan.shape[1] - 1, np.empty(5), 0
    for tower in range(len(plan)):
        n_out += plan[tower, last, OUT]
    outputs = len(memory) - 2 * n_out * BLOCK
    for start in range(0, len(index), BLOCK):
        here = index[start : start + BLOCK]
        n = len(here)
        _take(observations, here, memory, plan[0, 0, WIDE_IN])
        out = memory[outputs : outputs + n_out * n].reshape(n_out, n)
        d_out = memory[outputs + n_out * BLOCK : outputs + n_out * (BLOCK + n)].reshape(n_out, n)
        first = 0
        for tower in plan:
            _forward(tower, packed, memory, n)
            _turn(memory, tower[last, ABOVE], tower[last, WIDE_OUT], out[first : first + tower[last, OUT]])
            first += tower[last, OUT]
        loss_slopes(
            out[: n_out - 1],
            out[n_out - 1],
            offsets,
            choices,
            numbers,
            steps,
            here,
            settings[0],
            settings[1],
            settings[2],
            settings[3],
            settings[4],
            settings[5],
            settings[6],
            d_out[: n_out - 1],
            d_out[n_out - 1],
            part,
        )
        for i in range(5):
            terms[i] += part[i]
        first = 0
        for tower in plan:
            _turn_back(
                d_out[first : first + tower[last, OUT]], memory, tower[last, SLOPES], tower[last, WIDE_OUT]
            )
            first += tower[last, OUT]
            _backward(tower, packed, memory, n, sums)
    _unpack(sums, plan, gradient)


@lone_fused_njit
def _take(observations, index, memory, width):
    """Put what was observed at the beginning of memory, in rows of `width`."""
    for i in range(len(index)):
        row, to = observations[index[i]], memory[i * width : (i + 1) * width]
        for k in range(len(row)):
            to[k] = row[k]


@fused_njit
def _turn(memory, at, width, out):
    """Write the outputs f32[k, n] of a tower, which lie (n, width)."""
    for k in range(out.shape[0]):
        for i in range(out.shape[1]):
            out[k, i] = memory[at + i * width + k]


@fused_njit
def _turn_back(d_out, memory, at, width):
    """Put slopes f32[k, n] where those of the tower's outputs lie, (n, width)."""
    for k in range(d_out.shape[0]):
        for i in range(d_out.shape[1]):
            memory[at + i * width + k] = d_out[k, i]


@fused_njit
def _forward(tower, packed, memory, n):
    """Fill the activations of all layers for the first n rows; those up to the next multiple of 4 mean
    nothing."""
    below, rows = 0, (n + 3) // 4 * 4
    for layer in tower:
        wide, to = layer[WIDE_OUT], layer[ABOVE]
        _product(
            memory,
            below,
            layer[WIDE_IN],
            1,
            rows,
            layer[IN],
            packed,
            layer[FORTH],
            wide,
            packed,
            layer[SHIFT],
            0,
            memory,
            to,
        )
        if layer[SLOPES] != tower[-1, SLOPES]:
            _tanh_all(memory[to : to + rows * wide])
        below = to


@fused_njit
def _backward(tower, packed, memory, n, sums):
    """Add to the gradient of all weights what n rows give, from the slopes by the last layer's output."""
    rows = (n + 3) // 4 * 4
    for level in range(len(tower) - 1, -1, -1):
        layer = tower[level]
        wide, slopes = layer[WIDE_OUT], layer[SLOPES]
        below = tower[level - 1, ABOVE] if level else 0
        _add_rows(memory, slopes, n, wide, sums, layer[SHIFT])
        a, a_wide, units, b, b_wide = below, layer[WIDE_IN], layer[IN], slopes, wide
        if level == len(tower) - 1:  # the few outputs of a head fill up rows of tiles better than vectors
            a, a_wide, units, b, b_wide = slopes, wide, layer[OUT], below, layer[WIDE_IN]
        _product(
            memory,
            a,
            1,
            a_wide,
            (units + 3) // 4 * 4,
            n,
            memory,
            b,
            b_wide,
            sums,
            layer[FORTH],
            b_wide,
            sums,
            layer[FORTH],
        )
        if level:
            under, size = tower[level - 1, SLOPES], rows * layer[WIDE_IN]
            _product(
                memory,
                slopes,
                wide,
                1,
                rows,
                layer[OUT],
                packed,
                layer[BACK],
                layer[WIDE_IN],
                packed,
                len(packed) - layer[WIDE_IN],
                0,
                memory,
                under,
            )
            _through_tanh(memory[under : under + size], memory[below : below + size])


@fused_njit
def _tanh_all(h):
    for i in range(0, len(h), LANES):
        store(h, i, tanh(load(h, i)))


@lone_fused_njit
def _through_tanh(d, h):
    """Turn slopes by h = tanh(a) into slopes by a."""
    for i in range(len(d)):
        d[i] *= np.float32(1) - h[i] * h[i]


@fused_njit
def _add_rows(memory, at, n, width, sums, to):
    """Add n rows of `width` numbers to sums: two vectors at once, for each addition waits for the one before;
    of one vector, the same twice."""
    for lane in range(0, width, 2 * LANES):
        other = min(lane + LANES, width - LANES)
        u, v = load(sums, to + lane), load(sums, to + other)
        for start in range(at, at + n * width, width):
            u, v = u + load(memory, start + lane), v + load(memory, start + other)
        store(sums, to + lane, u)
        store(sums, to + other, v)


@fused_njit
def _product(a, at, row, step, rows, n, b, b_at, width, first, first_at, first_row, out, out_at):
    """Write out[rows, width] = first + a · b, the sum over n terms.

    Of a, f32[rows, n], rows are `row` and columns `step` apart, of b, f32[n, width], rows follow each other.
    Rows of `first` are `first_row` apart, 0 for a bias. `rows` is a multiple of 4, `width` of LANES; each
    array begins at its `_at`. Tiles are of four rows and one or two vectors, as the processor has registers.
    """
    even = width // (2 * LANES) * 2 * LANES if WIDE else 0
    for r in range(0, rows, 4):
        for lane in range(0, even, 2 * LANES):
            _two(
                a,
                at + r * row,
                row,
                step,
                n,
                b,
                b_at + lane,
                width,
                first,
                first_at + r * first_row + lane,
                first_row,
                out,
                out_at + r * width + lane,
            )
        for lane in range(even, width, LANES):
            _one(
                a,
                at + r * row,
                row,
                step,
                n,
                b,
                b_at + lane,
                width,
                first,
                first_at + r * first_row + lane,
                first_row,
                out,
                out_at + r * width + lane,
            )


@fused_njit
def _one(a, at, row, step, n, b, b_at, width, first, f, f_row, out, to):
    """Compute four rows of a vector."""
    u0, u1 = load(first, f), load(first, f + f_row)
    u2, u3 = load(first, f + 2 * f_row), load(first, f + 3 * f_row)
    for k in range(n):
        x, i = load(b, b_at + k * width), at + k * step
        u0, u1 = u0 + every(a, i) * x, u1 + every(a, i + row) * x
        u2, u3 = u2 + every(a, i + 2 * row) * x, u3 + every(a, i + 3 * row) * x
    _put(out, to, width, u0, u1, u2, u3)


@fused_njit
def _two(a, at, row, step, n, b, b_at, width, first, f, f_row, out, to):
    """Compute four rows of two vectors, u and v."""
    u0, u1 = load(first, f), load(first, f + f_row)
    u2, u3 = load(first, f + 2 * f_row), load(first, f + 3 * f_row)
    f += LANES
    v0, v1 = load(first, f), load(first, f + f_row)
    v2, v3 = load(first, f + 2 * f_row), load(first, f + 3 * f_row)
    for k in range(n):
        x, y = load(b, b_at + k * width), load(b, b_at + k * width + LANES)
        i = at + k * step
        p0, p1, p2, p3 = every(a, i), every(a, i + row), every(a, i + 2 * row), every(a, i + 3 * row)
        u0, u1, u2, u3 = u0 + p0 * x, u1 + p1 * x, u2 + p2 * x, u3 + p3 * x
        v0, v1, v2, v3 = v0 + p0 * y, v1 + p1 * y, v2 + p2 * y, v3 + p3 * y
    _put(out, to, width, u0, u1, u2, u3)
    _put(out, to + LANES, width, v0, v1, v2, v3)


@fused_njit
def _put(out, at, step, u0, u1, u2, u3):
    store(out, at, u0)
    store(out, at + step, u1)
    store(out, at + 2 * step, u2)
    store(out, at + 3 * step, u3)
