"""What a plain network says, without torch: a kernel over blocks of organisms,
whose sums no library takes in an order of its own.

Observations of a block are turned on their side, (units, organisms), so that all loops run along the
organisms, as vectors. A row's bits depend neither on the other rows, nor on its place among them, nor on the
number of threads.
"""

from __future__ import annotations

import numpy as np

from ecs_eco.learning.arithmetic import fused_njit, tanh

BLOCK = 64  # organisms: four vectors of the widest kind


@fused_njit
def infer(first, last, observations, weights, widths, starts, logits, values):
    """Write the outputs of a tower for rows first to last of the observations f32[n, widths[0]]:
    logits f32[n, k], values f32[n].

    `widths` i64[layers + 1] are those of the observations, the hidden layers and the output; `starts` i64[2 *
    layers] where each layer's matrix and bias begin in the weights: hidden matrices are (in, out), the last
    one (out, in). Output k is the value; a tower may have fewer.
    """
    n_layers, widest = len(widths) - 1, widths.max()
    below, above = np.zeros((widest, BLOCK), np.float32), np.zeros((widest, BLOCK), np.float32)
    for start in range(first, last, BLOCK):
        size = min(BLOCK, last - start)
        for i in range(size):
            for k in range(widths[0]):
                below[k, i] = observations[start + i, k]
        for level in range(n_layers):
            n_in, n_out = widths[level], widths[level + 1]
            matrix = weights[starts[2 * level] : starts[2 * level] + n_in * n_out]
            bias = weights[starts[2 * level + 1] : starts[2 * level + 1] + n_out]
            hidden = level < n_layers - 1
            _product(matrix, bias, n_in, n_out, n_out if hidden else 1, 1 if hidden else n_in, below, above)
            if hidden:
                for j in range(n_out):
                    unit = above[j]
                    for i in range(BLOCK):
                        unit[i] = tanh(unit[i])
            below, above = above, below
        for j in range(widths[n_layers]):
            for i in range(size):
                if j < logits.shape[1]:
                    logits[start + i, j] = below[j, i]
                else:
                    values[start + i] = below[j, i]


@fused_njit
def _product(matrix, bias, n_in, n_out, step_in, step_out, below, above):
    """Write above[n_out, BLOCK] = bias + matrix · below[n_in, BLOCK]; two units and four inputs at a time."""
    for j in range(0, n_out // 2 * 2, 2):
        u, v = above[j], above[j + 1]
        for i in range(BLOCK):
            u[i], v[i] = bias[j], bias[j + 1]
        for k in range(0, n_in // 4 * 4, 4):
            x0, x1, x2, x3 = below[k], below[k + 1], below[k + 2], below[k + 3]
            a = k * step_in + j * step_out
            b = a + step_out
            p0, p1, p2, p3 = matrix[a], matrix[a + step_in], matrix[a + 2 * step_in], matrix[a + 3 * step_in]
            q0, q1, q2, q3 = matrix[b], matrix[b + step_in], matrix[b + 2 * step_in], matrix[b + 3 * step_in]
            for i in range(BLOCK):
                u[i] += (x0[i] * p0 + x1[i] * p1) + (x2[i] * p2 + x3[i] * p3)
                v[i] += (x0[i] * q0 + x1[i] * q1) + (x2[i] * q2 + x3[i] * q3)
        for k in range(n_in // 4 * 4, n_in):
            _add(u, below[k], matrix[k * step_in + j * step_out])
            _add(v, below[k], matrix[k * step_in + (j + 1) * step_out])
    if n_out % 2:
        j = n_out - 1
        u = above[j]
        for i in range(BLOCK):
            u[i] = bias[j]
        for k in range(0, n_in // 4 * 4, 4):
            x0, x1, x2, x3 = below[k], below[k + 1], below[k + 2], below[k + 3]
            a = k * step_in + j * step_out
            p0, p1, p2, p3 = matrix[a], matrix[a + step_in], matrix[a + 2 * step_in], matrix[a + 3 * step_in]
            for i in range(BLOCK):
                u[i] += (x0[i] * p0 + x1[i] * p1) + (x2[i] * p2 + x3[i] * p3)
        for k in range(n_in // 4 * 4, n_in):
            _add(u, below[k], matrix[k * step_in + j * step_out])


@fused_njit
def _add(unit, below, weight):
    for i in range(BLOCK):
        unit[i] += below[i] * weight
