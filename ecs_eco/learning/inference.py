"""What a plain network says, without torch: a kernel over blocks of organisms,
whose sums no library takes in an order of its own.

Observations of a block are turned on their side, (units, organisms), so that all loops run along the
organisms, as vectors. A row's bits depend neither on the other rows, nor on its place among them, nor on the
number of threads.
"""

from __future__ import annotations

import numpy as np

from ecs_eco.engine.vectors import LANES, WIDE, every, load, store
from ecs_eco.learning.arithmetic import fused_njit, largest, tanh

BLOCK = 64  # organisms: four vectors of the widest kind
STEP = 2 * LANES if WIDE else LANES  # organisms whose units are computed at once


@fused_njit
def infer(first, last, observations, weights, widths, starts, logits, values):
    """Write the outputs of a tower for organisms first to last of the observations f32[widths[0], n]:
    logits f32[n, k], values f32[n].

    `widths` i64[layers + 1] are those of the observations, the hidden layers and the output; `starts` i64[2 *
    layers] where each layer's matrix and bias begin in the weights: hidden matrices are (in, out), the last
    one (out, in). Output k is the value; a tower may have fewer.
    """
    n_layers, widest, n_logits = len(widths) - 1, largest(widths), logits.shape[1]
    below, above = np.zeros(widest * BLOCK, np.float32), np.zeros(widest * BLOCK, np.float32)
    for start in range(first, last, BLOCK):
        size = min(BLOCK, last - start)
        width = (size + STEP - 1) // STEP * STEP  # the last block is often a small one
        _take(observations, widths[0], start, size, below)
        for level in range(n_layers):
            n_in, n_out = widths[level], widths[level + 1]
            matrix = weights[starts[2 * level] : starts[2 * level] + n_in * n_out]
            bias = weights[starts[2 * level + 1] : starts[2 * level + 1] + n_out]
            hidden = level < n_layers - 1
            _product(
                matrix, bias, n_in, n_out, n_out if hidden else 1, 1 if hidden else n_in, width, below, above
            )
            if hidden:
                for i in range(0, n_out * BLOCK, LANES):
                    store(above, i, tanh(load(above, i)))
            below, above = above, below
        for j in range(min(widths[n_layers], n_logits)):
            for i in range(size):
                logits[start + i, j] = below[j * BLOCK + i]
        if widths[n_layers] > n_logits:
            for i in range(size):
                values[start + i] = below[n_logits * BLOCK + i]


@fused_njit
def _take(observations, n, start, size, below):
    """Put what organisms from `start` on observe into a block: as vectors where each of the n observations
    lies in one piece."""
    if size == BLOCK and observations.strides[1] == 4:
        step = observations.strides[0] // 4
        for k in range(n):
            for lane in range(0, BLOCK, LANES):
                store(below, k * BLOCK + lane, load(observations, k * step + start + lane))
        return
    for k in range(n):
        for i in range(size):
            below[k * BLOCK + i] = observations[k, start + i]


@fused_njit
def _product(matrix, bias, n_in, n_out, step_in, step_out, width, below, above):
    """Write above[n_out, width] = bias + matrix · below[n_in, width], whose rows are BLOCK apart, in tiles of
    four units and one or two vectors, as the processor has registers, and the units that are left one by one.

    Each input is added to its unit as it is multiplied, which many processors do in one step.
    """
    for j in range(0, n_out // 4 * 4, 4):
        if WIDE:
            for lane in range(0, width, 2 * LANES):
                _two(matrix, bias, n_in, j, step_in, step_out, below, above, lane)
        else:
            for lane in range(0, width, LANES):
                _one(matrix, bias, n_in, j, step_in, step_out, below, above, lane)
    for j in range(n_out // 4 * 4, n_out):
        _unit(matrix, bias, n_in, j, step_in, step_out, width, below, above)


@fused_njit
def _one(matrix, bias, n_in, j, step_in, step_out, below, above, lane):
    """Compute units j … j + 3 of a vector of organisms."""
    u0, u1, u2, u3 = every(bias, j), every(bias, j + 1), every(bias, j + 2), every(bias, j + 3)
    for k in range(n_in):
        x, at = load(below, k * BLOCK + lane), k * step_in + j * step_out
        u0, u1 = u0 + x * every(matrix, at), u1 + x * every(matrix, at + step_out)
        u2, u3 = u2 + x * every(matrix, at + 2 * step_out), u3 + x * every(matrix, at + 3 * step_out)
    _put(above, j * BLOCK + lane, u0, u1, u2, u3)


@fused_njit
def _two(matrix, bias, n_in, j, step_in, step_out, below, above, lane):
    """Compute units j … j + 3 of two vectors of organisms, u and v."""
    u0, u1, u2, u3 = every(bias, j), every(bias, j + 1), every(bias, j + 2), every(bias, j + 3)
    v0, v1, v2, v3 = u0, u1, u2, u3
    for k in range(n_in):
        x, y = load(below, k * BLOCK + lane), load(below, k * BLOCK + lane + LANES)
        at = k * step_in + j * step_out
        p0, p1, p2, p3 = (
            every(matrix, at),
            every(matrix, at + step_out),
            every(matrix, at + 2 * step_out),
            every(matrix, at + 3 * step_out),
        )
        u0, u1, u2, u3 = u0 + x * p0, u1 + x * p1, u2 + x * p2, u3 + x * p3
        v0, v1, v2, v3 = v0 + y * p0, v1 + y * p1, v2 + y * p2, v3 + y * p3
    _put(above, j * BLOCK + lane, u0, u1, u2, u3)
    _put(above, j * BLOCK + lane + LANES, v0, v1, v2, v3)


@fused_njit
def _put(above, at, u0, u1, u2, u3):
    store(above, at, u0)
    store(above, at + BLOCK, u1)
    store(above, at + 2 * BLOCK, u2)
    store(above, at + 3 * BLOCK, u3)


@fused_njit
def _unit(matrix, bias, n_in, j, step_in, step_out, width, below, above):
    """Compute unit j: of the four vectors of a whole block at once, of fewer one by one."""
    if width == BLOCK:
        a = b = c = d = every(bias, j)
        for k in range(n_in):
            weight, at = every(matrix, k * step_in + j * step_out), k * BLOCK
            a, b = a + weight * load(below, at), b + weight * load(below, at + LANES)
            c, d = c + weight * load(below, at + 2 * LANES), d + weight * load(below, at + 3 * LANES)
        at = j * BLOCK
        store(above, at, a)
        store(above, at + LANES, b)
        store(above, at + 2 * LANES, c)
        store(above, at + 3 * LANES, d)
        return
    for lane in range(0, width, LANES):
        a = every(bias, j)
        for k in range(n_in):
            a = a + every(matrix, k * step_in + j * step_out) * load(below, k * BLOCK + lane)
        store(above, j * BLOCK + lane, a)
