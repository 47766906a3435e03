"""Inference with plain networks, without torch: kernels with a fixed order of summation.

An organism's output is bit-identical regardless of the other organisms, its position and the number of
threads.
"""

from __future__ import annotations

import numpy as np

from ecs_eco.compiled.vectors import LANES, every, load, prefetch, spread, store
from ecs_eco.engine.blocks import BLOCK as ROWS_OF_BLOCK, apart, flat_block_of
from ecs_eco.learning.arithmetic import fused_njit, lone_fused_njit, tanh
from ecs_eco.learning.layers import layer_of
from ecs_eco.learning.tiles import ROWS, product, round_up

BLOCK = 64  # organisms: four of the widest vectors


@fused_njit
def infer_shared(first, last, observations, weights, layers, logits, values):
    """Write the outputs of one network with weights f32[size] for organisms first … last − 1 of the
    observations f32[c, n]: logits f32[n, k], values f32[n].

    Each block of observations is transposed to (units, organisms), so that all loops run over organisms and
    can be vectorized.
    """
    n_observations, n_logits = observations.shape[0], logits.shape[1]
    widest = units = 0
    for level in range(len(layers)):
        layer = layer_of(layers, level)
        widest, units = max(widest, layer.outputs), units + round_up(layer.outputs, ROWS)
    biases = len(weights) + LANES
    observed = biases + units * LANES
    below = observed + n_observations * BLOCK
    above = below + round_up(widest, ROWS) * BLOCK
    scratch = np.zeros(above + round_up(widest, ROWS) * BLOCK, np.float32)
    _lay_weights(weights, layers, biases, scratch)
    for start in range(first, last, BLOCK):
        size = min(BLOCK, last - start)
        width, bias, output = round_up(size, LANES), biases, 0
        _take(observations, start, size, scratch, observed)
        for level in range(len(layers)):
            layer = layer_of(layers, level)
            a, b, source = layer.inputs, layer.outputs, below if layer.below else observed
            product(scratch, layer.weights, 1, b, b, source, BLOCK, a, bias, LANES, above, BLOCK, width)
            bias += round_up(b, ROWS) * LANES
            if layer.hidden:
                for i in range(above, above + b * BLOCK, LANES):
                    store(scratch, i, tanh(load(scratch, i)))
                below, above = above, below
                continue
            for o in range(b):
                for i in range(size):
                    number = scratch[above + o * BLOCK + i]
                    if output + o < n_logits:
                        logits[start + i, output + o] = number
                    else:
                        values[start + i] = number
            output += b


@lone_fused_njit
def _lay_weights(weights, layers, biases, scratch):
    """Copy the weights, repeating each bias to fill a vector."""
    for i in range(len(weights)):
        scratch[i] = weights[i]
    for level in range(len(layers)):
        layer = layer_of(layers, level)
        bias = layer.weights + layer.inputs * layer.outputs
        for o in range(layer.outputs):
            for lane in range(LANES):
                scratch[biases + o * LANES + lane] = weights[bias + o]
        biases += round_up(layer.outputs, ROWS) * LANES


@fused_njit
def _take(observations, start, size, scratch, to):
    """Copy organisms' observations, starting at `start`, into a block, as vectors if each of the n is
    contiguous."""
    n = observations.shape[0]
    if size == BLOCK and observations.strides[1] == 4:
        step = observations.strides[0] // 4
        for k in range(n):
            for lane in range(0, BLOCK, LANES):
                store(scratch, to + k * BLOCK + lane, load(observations, k * step + start + lane))
        return
    for k in range(n):
        for i in range(size):
            scratch[to + k * BLOCK + i] = observations[k, start + i]


@lone_fused_njit
def infer_individual(first, last, rows, weights, layers, x, logits, values):
    """Write the logits f32[n, k] and values f32[n] of animals first … last − 1 with observations f32[n, c],
    each with its own weights: row `rows[j]` of a column from `Blocked.by_address` for animal j.

    A layer's inputs are summed in four groups, each of which contains every fourth input. Up to LANES numbers
    after each animal's weights are read but ignored.
    """
    zero, k, size, wide = spread(np.float32(0)), logits.shape[1], weights[1].shape[1], x.shape[1]
    for level in range(len(layers)):
        layer = layer_of(layers, level)
        wide = max(wide, layer.outputs)
    wide = round_up(wide, LANES)
    units = np.zeros(2 * wide, np.float32)
    for j in range(first, last):
        w, start, below, above = flat_block_of(rows[j], weights), rows[j] % ROWS_OF_BLOCK * size, 0, wide
        ahead = apart(rows[j], rows[min(j + 1, last - 1)], weights)  # the next animal's weights
        for i in range(x.shape[1]):
            units[i] = x[j, i]
        for level in range(len(layers)):
            layer = layer_of(layers, level)
            a, b, at = layer.inputs, layer.outputs, start + layer.weights
            for o in range(0, b, LANES):
                here, y0, y1, y2, y3 = at + o, load(w, at + o + a * b), zero, zero, zero
                for i in range(below, below + a // 4 * 4, 4):
                    y0, y1 = (
                        y0 + every(units, i) * load(w, here),
                        y1 + every(units, i + 1) * load(w, here + b),
                    )
                    y2, y3 = (
                        y2 + every(units, i + 2) * load(w, here + 2 * b),
                        y3 + every(units, i + 3) * load(w, here + 3 * b),
                    )
                    for _ in range(4):
                        prefetch(w, here + ahead)
                        here += b
                for i in range(below + a // 4 * 4, below + a):
                    y0 = y0 + every(units, i) * load(w, here)
                    here += b
                y0 = (y0 + y1) + (y2 + y3)
                store(units, above + o, tanh(y0) if layer.hidden else y0)
            below, above = above, below
        for o in range(k):
            logits[j, o] = units[np.uint64(below + o)]
        values[j] = units[below + k]
