"""The gradient of PPO's loss with respect to a plain network's weights, shared or individual: forward, loss,
backward.

Everything is in one flat array, the scratch: the activations of all layers, the deltas (the gradient with
respect to each layer's sums before tanh), the weights, their gradient, and the fields of `Layout`. A layer's
activations are (rows, wide): one row per transition, padded to a multiple of ROWS; wide is the number of the
layer's units, padded to a multiple of LANES. Padding after the units and after a matrix's rows is read but
ignored.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecs_eco.compiled.vectors import LANES, load, spread, store
from ecs_eco.learning.arithmetic import fused_njit, lone_fused_njit, tanh
from ecs_eco.learning.layers import layer_of
from ecs_eco.learning.loss import allocate_scratch, gather_transitions, output_gradient, take_terms
from ecs_eco.learning.tiles import ROWS, column_sums, product, round_up

BLOCK = 64  # transitions per pass through a shared network; their activations stay in the cache


class Layout(NamedTuple):
    """The start of each part of the scratch that follows the activations."""

    deltas: int
    weights: int
    gradient: int
    transposed: int  # the matrices above the first layer, (out, in)
    zeros: int
    head: int  # the gradient with respect to a head's matrix, (out, in)
    end: int


@fused_njit
def layout_of(layers, rows):
    """Return the layout of a scratch for up to `rows` transitions; `layers` is the table in layers.py."""
    units = size = transposed = widest = head = 0
    for level in range(len(layers)):
        layer = layer_of(layers, level)
        narrow, wide = round_up(layer.inputs, LANES), round_up(layer.outputs, LANES)
        units, size = layer.above + wide, size + (layer.inputs + 1) * layer.outputs
        transposed, widest = layer.transposed + layer.outputs * narrow, max(widest, narrow, wide)
        head = max(head, 0 if layer.hidden else round_up(layer.outputs, ROWS) * narrow)
    deltas = round_up(rows, ROWS) * units
    gradient = 2 * deltas + size + LANES
    there = gradient + size + ROWS * widest + LANES  # tiles extend beyond the gradient
    zeros = there + transposed
    return Layout(deltas, 2 * deltas, gradient, there, zeros, zeros + widest, zeros + widest + head)


@lone_fused_njit
def gather_observations(observations, chosen, scratch):
    """Write the chosen observations [t, c] to the input layer, and fill the rows after them with zeros."""
    n, c, wide = len(chosen), observations.shape[1], round_up(observations.shape[1], LANES)
    for i in range(n * wide, round_up(n, ROWS) * wide):
        scratch[np.uint64(i)] = 0
    for i in range(n):
        t = chosen[i]
        for k in range(c):
            scratch[np.uint64(i * wide + k)] = observations[t, k]


@fused_njit
def transpose_weights(scratch, layout, layers):
    """Transpose the matrix (a, b) of each layer above the first to (b, wide), whenever weights have changed."""
    for level in range(len(layers)):
        layer = layer_of(layers, level)
        a, b, wide = layer.inputs, layer.outputs, round_up(layer.inputs, LANES)
        matrix, transposed = layout.weights + layer.weights, layout.transposed + layer.transposed
        for i in range(a if layer.below else 0):
            for o in range(b):
                scratch[np.uint64(transposed + o * wide + i)] = scratch[np.uint64(matrix + i * b + o)]


@fused_njit
def forward(scratch, layout, layers, rows):
    """Fill the activations of all layers from the observations."""
    for level in range(len(layers)):
        layer = layer_of(layers, level)
        a, b, matrix = layer.inputs, layer.outputs, layout.weights + layer.weights
        narrow, wide, above = round_up(a, LANES), round_up(b, LANES), rows * layer.above
        product(
            scratch, rows * layer.below, narrow, 1, rows, matrix, b, a, matrix + a * b, 0, above, wide, wide
        )
        if layer.hidden:
            for i in range(above, above + rows * wide, LANES):
                store(scratch, i, tanh(load(scratch, i)))


@fused_njit
def backward(scratch, layout, layers, rows, n):
    """Compute the gradient from the output deltas of n transitions."""
    for level in range(len(layers) - 1, -1, -1):
        layer = layer_of(layers, level)
        narrow, wide = round_up(layer.inputs, LANES), round_up(layer.outputs, LANES)
        above, below = layout.deltas + rows * layer.above, layout.deltas + rows * layer.below
        transposed, zeros = layout.transposed + layer.transposed, layout.zeros
        if layer.below:
            b = layer.outputs
            product(scratch, above, wide, 1, rows, transposed, narrow, b, zeros, 0, below, narrow, narrow)
            _through_tanh(scratch, below, rows * layer.below, rows * narrow)
    for level in range(len(layers)):  # in ascending order, because tiles extend beyond their own block
        layer = layer_of(layers, level)
        a, b, gradient = layer.inputs, layer.outputs, layout.gradient + layer.weights
        narrow, wide, deltas = round_up(a, LANES), round_up(b, LANES), layout.deltas + rows * layer.above
        if layer.hidden:
            product(
                scratch, rows * layer.below, 1, narrow, a, deltas, wide, n, layout.zeros, 0, gradient, b, b
            )
        else:
            _head_gradient(scratch, layout, layer, deltas, rows, n, gradient)
        column_sums(scratch, deltas, rows, wide, gradient + a * b)


@fused_njit
def _head_gradient(scratch, layout, layer, deltas, rows, n, gradient):
    """Write the gradient with respect to a head's matrix; its few outputs fill tile rows better than vectors."""
    a, b, turned = layer.inputs, layer.outputs, layout.head
    narrow, wide = round_up(a, LANES), round_up(b, LANES)
    product(
        scratch, deltas, 1, wide, b, rows * layer.below, narrow, n, layout.zeros, 0, turned, narrow, narrow
    )
    for i in range(a):
        for o in range(b):
            scratch[np.uint64(gradient + i * b + o)] = scratch[np.uint64(turned + o * narrow + i)]


@fused_njit
def _through_tanh(scratch, deltas, h, n):
    """Multiply n numbers of the gradient by the derivative of tanh, computed from its outputs at h."""
    one = spread(np.float32(1))
    for i in range(0, n, LANES):
        y = load(scratch, h + i)
        store(scratch, deltas + i, load(scratch, deltas + i) * (one - y * y))


@fused_njit
def loss_gradient(scratch, layout, layers, n, offsets, settings, loss):
    """Write the gradient of the loss over n transitions with respect to the weights; add the loss's terms to
    `loss`. Both scratches contain the transitions, and the network's also contains the transposed weights."""
    rows = round_up(n, ROWS)
    forward(scratch, layout, layers, rows)
    output_gradient(scratch, layout.deltas, layers, rows, n, offsets, settings, loss)
    backward(scratch, layout, layers, rows, n)


@fused_njit
def shared_gradient(scratch, weights, layers, offsets, log, chosen, settings, share, gradient, terms):
    """Write the gradient f32[size] of the loss over the chosen transitions i64[n], each with the weight
    `share`, and the sums of its terms, f64[5].

    `scratch`, initially zeros, is for this network only (see `scratch_for`); `log` contains a rollout's
    observations, choices, numbers and steps. The gradient of each block is summed separately.
    """
    observations, choices, numbers, steps = log
    layout, loss = layout_of(layers, BLOCK), allocate_scratch(offsets, numbers.shape[1], BLOCK)
    for i in range(len(weights)):
        scratch[np.uint64(layout.weights + i)] = weights[i]
        gradient[i] = 0
    transpose_weights(scratch, layout, layers)
    for start in range(0, len(chosen), BLOCK):
        here = chosen[start : start + BLOCK]
        gather_observations(observations, here, scratch)
        gather_transitions(loss, steps, choices, numbers, offsets, here, share)
        loss_gradient(scratch, layout, layers, len(here), offsets, settings, loss)
        for i in range(len(gradient)):
            gradient[i] += scratch[np.uint64(layout.gradient + i)]
    take_terms(loss, terms)


def scratch_for(layers: np.ndarray) -> np.ndarray:
    """Return the scratch for `shared_gradient`."""
    return np.zeros(layout_of(layers, BLOCK).end, np.float32)
