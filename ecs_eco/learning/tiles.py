"""Matrix products over multiples of LANES columns, with sums in registers: networks of single animals."""

from __future__ import annotations

from ecs_eco.engine.vectors import LANES as VECTOR
from ecs_eco.engine.vectors import every, load, store
from ecs_eco.learning.arithmetic import fused_njit

LANES = 2 * VECTOR


@fused_njit
def add_product(matrix, below, above):
    """Add matrix.T @ below to above, in tiles of four units and LANES transitions.

    The matrix f32[n_in, n_out] has any strides; below f32[n_in, k * LANES] and above f32[n_out, k * LANES]
    are contiguous.
    """
    n_in, n_out = matrix.shape
    lanes, step_in, step_out = below.shape[1], matrix.strides[0] // 4, matrix.strides[1] // 4
    for o in range(0, n_out // 4 * 4, 4):
        for lane in range(0, lanes, LANES):
            _tile(matrix, below, above, n_in, o * step_out, step_in, step_out, o * lanes + lane, lane, lanes)
    for o in range(n_out // 4 * 4, n_out):
        for lane in range(0, lanes, VECTOR):
            y = load(above, o * lanes + lane)
            for i in range(n_in):
                y = y + every(matrix, i * step_in + o * step_out) * load(below, i * lanes + lane)
            store(above, o * lanes + lane, y)


@fused_njit
def _tile(matrix, below, above, n_in, w, step_in, step_out, at, x, lanes):
    """Add to four units, of two vectors of transitions each, y and z; two units below at a time."""
    y0, y1, y2, y3 = (load(above, at), load(above, at + lanes), load(above, at + 2 * lanes),
                      load(above, at + 3 * lanes))
    to = at + VECTOR
    z0, z1, z2, z3 = (load(above, to), load(above, to + lanes), load(above, to + 2 * lanes),
                      load(above, to + 3 * lanes))
    for i in range(0, n_in // 2 * 2, 2):
        a, b = load(below, i * lanes + x), load(below, i * lanes + lanes + x)
        c, d = load(below, i * lanes + x + VECTOR), load(below, i * lanes + lanes + x + VECTOR)
        v = i * step_in + w
        y0, z0 = y0 + _two(matrix, v, step_in, a, b), z0 + _two(matrix, v, step_in, c, d)
        v += step_out
        y1, z1 = y1 + _two(matrix, v, step_in, a, b), z1 + _two(matrix, v, step_in, c, d)
        v += step_out
        y2, z2 = y2 + _two(matrix, v, step_in, a, b), z2 + _two(matrix, v, step_in, c, d)
        v += step_out
        y3, z3 = y3 + _two(matrix, v, step_in, a, b), z3 + _two(matrix, v, step_in, c, d)
    for i in range(n_in // 2 * 2, n_in):
        a, c, v = load(below, i * lanes + x), load(below, i * lanes + x + VECTOR), i * step_in + w
        p0, p1, p2, p3 = (every(matrix, v), every(matrix, v + step_out), every(matrix, v + 2 * step_out),
                          every(matrix, v + 3 * step_out))
        y0, y1, y2, y3 = y0 + p0 * a, y1 + p1 * a, y2 + p2 * a, y3 + p3 * a
        z0, z1, z2, z3 = z0 + p0 * c, z1 + p1 * c, z2 + p2 * c, z3 + p3 * c
    _put(above, at, lanes, y0, y1, y2, y3)
    _put(above, to, lanes, z0, z1, z2, z3)


@fused_njit
def _two(matrix, at, step, a, b):
    return every(matrix, at) * a + every(matrix, at + step) * b


@fused_njit
def _put(above, at, lanes, y0, y1, y2, y3):
    store(above, at, y0)
    store(above, at + lanes, y1)
    store(above, at + 2 * lanes, y2)
    store(above, at + 3 * lanes, y3)
