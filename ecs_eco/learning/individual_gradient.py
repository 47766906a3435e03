"""Activations and gradient of one animal's network over some of its transitions.

All is in one flat array, the room: the activations of all layers, the slopes by them, the weights, their
gradient, and what `layout` names. A layer's activations are (rows, wide), a row for each transition, up to a
multiple of ROWS, and wide the layer's units, up to a multiple of LANES. What is behind the units, and behind
a matrix's rows, is read and let be.
"""

from __future__ import annotations

import numpy as np

from ecs_eco.compiled.vectors import LANES, load, spread, store
from ecs_eco.learning.arithmetic import fused_njit, lone_fused_njit, tanh
from ecs_eco.learning.tiles import ROWS, column_sums, product, up


@fused_njit
def layout(widths, horizon):
    """Return where in the room, of up to `horizon` transitions, slopes begin, weights, their gradient, a
    matrix that is turned, and zeros; and the size of all."""
    units = turned = widest = size = 0
    for i in range(len(widths)):
        wide = up(widths[i], LANES)
        units, widest = units + wide, max(widest, wide)
        if i > 0:
            size += (widths[i - 1] + 1) * widths[i]
            turned = max(turned, (widths[i] + 1) * up(widths[i - 1], LANES))
    slopes = up(horizon, ROWS) * units
    gradient = 2 * slopes + size + LANES
    there = gradient + size + ROWS * widest + LANES  # tiles go beyond it
    return slopes, 2 * slopes, gradient, there, there + turned, there + turned + widest


@lone_fused_njit
def fetch(observations, at, chosen, room):
    """Write the chosen observations [at, t, c] to the input layer, zeros into the rows behind them."""
    n, c, wide = len(chosen), observations.shape[2], up(observations.shape[2], LANES)
    for i in range(n * wide, up(n, ROWS) * wide):
        room[np.uint64(i)] = 0
    for i in range(n):
        t = chosen[i]
        for k in range(c):
            room[np.uint64(i * wide + k)] = observations[at, t, k]


@fused_njit
def forward(room, places, widths, rows):
    """Fill the activations of all layers from the first's; return where the last begins."""
    w, below = places[1], 0
    for layer in range(len(widths) - 1):
        a, b = widths[layer], widths[layer + 1]
        narrow, wide = up(a, LANES), up(b, LANES)
        above = below + rows * narrow
        product(room, below, narrow, 1, rows, w, b, a, w + a * b, above, wide, wide)
        if layer < len(widths) - 2:
            for i in range(above, above + rows * wide, LANES):
                store(room, i, tanh(load(room, i)))
        w, below = w + (a + 1) * b, above
    return below


@fused_njit
def backward(room, places, widths, rows, n, unit):
    """Fill the gradient from the slopes by the outputs, of n transitions in these rows, of which the
    activations begin at `unit`; from the first layer to the last, for tiles go beyond what is theirs."""
    slopes, _, gradient, turned, zeros, _ = places
    w = gradient - LANES
    for layer in range(len(widths) - 2, 0, -1):
        a, b = widths[layer], widths[layer + 1]
        narrow, wide, w = up(a, LANES), up(b, LANES), w - (a + 1) * b
        _turn(room, w, a, b, turned, narrow)
        below = unit - rows * narrow
        product(room, slopes + unit, wide, 1, rows, turned, narrow, b, zeros, slopes + below, narrow, narrow)
        _through_tanh(room, slopes + below, below, rows * narrow)
        unit = below
    unit = 0
    for layer in range(len(widths) - 1):
        a, b = widths[layer], widths[layer + 1]
        narrow, wide = up(a, LANES), up(b, LANES)
        above = unit + rows * narrow
        product(room, unit, 1, narrow, a, slopes + above, wide, n, zeros, gradient, b, b)
        column_sums(room, slopes + above, rows, wide, gradient + a * b)
        gradient, unit = gradient + (a + 1) * b, above


@fused_njit
def _turn(room, matrix, a, b, turned, narrow):
    """Write a layer's matrix (a, b) as (b, narrow)."""
    for i in range(a):
        for o in range(b):
            room[np.uint64(turned + o * narrow + i)] = room[np.uint64(matrix + i * b + o)]


@fused_njit
def _through_tanh(room, slopes, h, n):
    """Turn n slopes by tanh's results h into those by what it was taken of."""
    one = spread(np.float32(1))
    for i in range(0, n, LANES):
        y = load(room, h + i)
        store(room, slopes + i, load(room, slopes + i) * (one - y * y))
