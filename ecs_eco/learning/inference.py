"""What a plain network says, without torch: a kernel over blocks of organisms,
whose sums no library takes in an order of its own.

Observations of a block are turned on their side, (units, organisms), so that all loops run along the
organisms, as vectors. A row's bits depend neither on the other rows, nor on its place among them, nor on the
number of threads.
"""

from __future__ import annotations

import numpy as np

from ecs_eco.engine.vectors import LANES, every, load, store
from ecs_eco.learning.arithmetic import fused_njit, tanh

BLOCK = 64  # organisms: four vectors of the widest kind


@fused_njit
def infer(first, last, observations, weights, widths, starts, logits, values):
    """Write the outputs of a tower for organisms first to last of the observations f32[widths[0], n]:
    logits f32[n, k], values f32[n].

    `widths` i64[layers + 1] are those of the observations, the hidden layers and the output; `starts` i64[2 *
    layers] where each layer's matrix and bias begin in the weights: hidden matrices are (in, out), the last
    one (out, in). Output k is the value; a tower may have fewer.
    """
    n_layers, widest = len(widths) - 1, widths.max()
    below, above = np.zeros(widest * BLOCK, np.float32), np.zeros(widest * BLOCK, np.float32)
    for start in range(first, last, BLOCK):
        size = min(BLOCK, last - start)
        for k in range(widths[0]):
            for i in range(size):
                below[k * BLOCK + i] = observations[k, start + i]
        for level in range(n_layers):
            n_in, n_out = widths[level], widths[level + 1]
            matrix = weights[starts[2 * level] : starts[2 * level] + n_in * n_out]
            bias = weights[starts[2 * level + 1] : starts[2 * level + 1] + n_out]
            hidden = level < n_layers - 1
            _product(matrix, bias, n_in, n_out, n_out if hidden else 1, 1 if hidden else n_in, below, above)
            if hidden:
                for i in range(n_out * BLOCK):
                    above[i] = tanh(above[i])
            below, above = above, below
        for j in range(widths[n_layers]):
            for i in range(size):
                if j < logits.shape[1]:
                    logits[start + i, j] = below[j * BLOCK + i]
                else:
                    values[start + i] = below[j * BLOCK + i]


@fused_njit
def _product(matrix, bias, n_in, n_out, step_in, step_out, below, above):
    """Write above[n_out, BLOCK] = bias + matrix · below[n_in, BLOCK], in tiles of four units and two vectors.

    Four inputs are added up before they go to their unit.
    """
    for j in range(0, n_out // 4 * 4, 4):
        for lane in range(0, BLOCK, 2 * LANES):
            _tile(matrix, bias, n_in, j, step_in, step_out, below, above, lane)
    for j in range(n_out // 4 * 4, n_out):
        for lane in range(0, BLOCK, LANES):
            _one(matrix, bias, n_in, j, step_in, step_out, below, above, lane)


@fused_njit
def _tile(matrix, bias, n_in, j, step_in, step_out, below, above, lane):
    """Compute units j … j + 3 of two vectors of organisms, u and v."""
    full = n_in // 4 * 4
    u0, u1, u2, u3 = every(bias, j), every(bias, j + 1), every(bias, j + 2), every(bias, j + 3)
    v0, v1, v2, v3 = u0, u1, u2, u3
    for k in range(0, full, 4):
        x, at = k * BLOCK + lane, k * step_in + j * step_out
        x0, x1, x2, x3 = (load(below, x), load(below, x + BLOCK), load(below, x + 2 * BLOCK),
                          load(below, x + 3 * BLOCK))
        x += LANES
        y0, y1, y2, y3 = (load(below, x), load(below, x + BLOCK), load(below, x + 2 * BLOCK),
                          load(below, x + 3 * BLOCK))
        u0 = u0 + _four(x0, x1, x2, x3, matrix, at, step_in)
        v0 = v0 + _four(y0, y1, y2, y3, matrix, at, step_in)
        at += step_out
        u1 = u1 + _four(x0, x1, x2, x3, matrix, at, step_in)
        v1 = v1 + _four(y0, y1, y2, y3, matrix, at, step_in)
        at += step_out
        u2 = u2 + _four(x0, x1, x2, x3, matrix, at, step_in)
        v2 = v2 + _four(y0, y1, y2, y3, matrix, at, step_in)
        at += step_out
        u3 = u3 + _four(x0, x1, x2, x3, matrix, at, step_in)
        v3 = v3 + _four(y0, y1, y2, y3, matrix, at, step_in)
    for k in range(full, n_in):
        x, y = load(below, k * BLOCK + lane), load(below, k * BLOCK + lane + LANES)
        at = k * step_in + j * step_out
        p0, p1, p2, p3 = (every(matrix, at), every(matrix, at + step_out), every(matrix, at + 2 * step_out),
                          every(matrix, at + 3 * step_out))
        u0, u1, u2, u3 = u0 + x * p0, u1 + x * p1, u2 + x * p2, u3 + x * p3
        v0, v1, v2, v3 = v0 + y * p0, v1 + y * p1, v2 + y * p2, v3 + y * p3
    at = j * BLOCK + lane
    store(above, at, u0)
    store(above, at + BLOCK, u1)
    store(above, at + 2 * BLOCK, u2)
    store(above, at + 3 * BLOCK, u3)
    at += LANES
    store(above, at, v0)
    store(above, at + BLOCK, v1)
    store(above, at + 2 * BLOCK, v2)
    store(above, at + 3 * BLOCK, v3)


@fused_njit
def _one(matrix, bias, n_in, j, step_in, step_out, below, above, lane):
    """Compute unit j of one vector of organisms."""
    full, u = n_in // 4 * 4, every(bias, j)
    for k in range(0, full, 4):
        x = k * BLOCK + lane
        u = u + _four(load(below, x), load(below, x + BLOCK), load(below, x + 2 * BLOCK),
                      load(below, x + 3 * BLOCK), matrix, k * step_in + j * step_out, step_in)
    for k in range(full, n_in):
        u = u + load(below, k * BLOCK + lane) * every(matrix, k * step_in + j * step_out)
    store(above, j * BLOCK + lane, u)


@fused_njit
def _four(x0, x1, x2, x3, matrix, at, step):
    """The sum of four inputs times their weights, which stand `step` apart."""
    return (x0 * every(matrix, at) + x1 * every(matrix, at + step)) + (
        x2 * every(matrix, at + 2 * step) + x3 * every(matrix, at + 3 * step))
