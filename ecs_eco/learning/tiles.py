"""Matrix products for small networks, with sums in registers.

Matrices are in one flat array and addressed by their first position, because numba counts references to every
slice atomically.
"""

from __future__ import annotations

from ecs_eco.compiled.vectors import LANES, WIDE, every, load, store
from ecs_eco.learning.arithmetic import fused_njit

ROWS = 4  # rows per tile: with two registers per row, as many sums as AVX2 needs in flight


@fused_njit
def round_up(n, multiple):
    """Return the smallest multiple that is at least n."""
    return (n + multiple - 1) // multiple * multiple


@fused_njit
def product(scratch, x, step_row, step, rows, matrix, step_matrix, n, bias, bias_row, out, step_out, columns):
    """Write out (rows, columns) = bias + x · matrix (n, columns), in tiles of ROWS rows and one vector, or
    two if the processor has enough registers.

    Number k of row r of x is at x + r * step_row + k * step in the scratch f32[…], row k of the matrix is at
    matrix + k * step_matrix, and row r of the result is at out + r * step_out. A bias with `bias_row` 0 has
    one number per column; otherwise, row r's bias is a vector at bias + r * bias_row. Tiles extend beyond
    rows and columns: extra input is ignored and extra output is overwritten later; after the last row, up to
    ROWS - 1 rows and LANES numbers are overwritten. Each number is summed in the order of k, independently of
    the other numbers.
    """
    step_bias = 0 if bias_row else 1
    for r in range(0, rows, ROWS):
        lane = (columns - 1) // LANES * LANES
        while lane >= 0:
            pair = WIDE and lane > 0
            lane -= LANES if pair else 0
            at, w, to = x + r * step_row, matrix + lane, out + r * step_out + lane
            first = bias + r * bias_row + lane * step_bias
            if pair:
                _pair(
                    scratch, at, step_row, step, w, step_matrix, n, first, bias_row, step_bias, to, step_out
                )
            else:
                _single(scratch, at, step_row, step, w, step_matrix, n, first, bias_row, to, step_out)
            lane -= LANES


@fused_njit
def _single(scratch, x, step_row, step, matrix, step_matrix, n, bias, bias_row, out, step_out):
    """Compute four rows of one vector."""
    y0, y1 = load(scratch, bias), load(scratch, bias + bias_row)
    y2, y3 = load(scratch, bias + 2 * bias_row), load(scratch, bias + 3 * bias_row)
    for _ in range(n):
        w = load(scratch, matrix)
        y0 = y0 + every(scratch, x) * w
        y1 = y1 + every(scratch, x + step_row) * w
        y2 = y2 + every(scratch, x + 2 * step_row) * w
        y3 = y3 + every(scratch, x + 3 * step_row) * w
        x += step
        matrix += step_matrix
    _put(scratch, out, step_out, y0, y1, y2, y3)


@fused_njit
def _pair(scratch, x, step_row, step, matrix, step_matrix, n, bias, bias_row, step_bias, out, step_out):
    """Compute four rows of two vectors, y and z."""
    y0, y1 = load(scratch, bias), load(scratch, bias + bias_row)
    y2, y3 = load(scratch, bias + 2 * bias_row), load(scratch, bias + 3 * bias_row)
    bias += LANES * step_bias
    z0, z1 = load(scratch, bias), load(scratch, bias + bias_row)
    z2, z3 = load(scratch, bias + 2 * bias_row), load(scratch, bias + 3 * bias_row)
    for _ in range(n):
        v, w = load(scratch, matrix), load(scratch, matrix + LANES)
        x0, x1 = every(scratch, x), every(scratch, x + step_row)
        x2, x3 = every(scratch, x + 2 * step_row), every(scratch, x + 3 * step_row)
        y0, y1, y2, y3 = y0 + x0 * v, y1 + x1 * v, y2 + x2 * v, y3 + x3 * v
        z0, z1, z2, z3 = z0 + x0 * w, z1 + x1 * w, z2 + x2 * w, z3 + x3 * w
        x += step
        matrix += step_matrix
    _put(
        scratch, out + LANES, step_out, z0, z1, z2, z3
    )  # computed first, because it can extend into the next row's first vector
    _put(scratch, out, step_out, y0, y1, y2, y3)


@fused_njit
def _put(scratch, out, step_out, y0, y1, y2, y3):
    store(scratch, out, y0)
    store(scratch, out + step_out, y1)
    store(scratch, out + 2 * step_out, y2)
    store(scratch, out + 3 * step_out, y3)


@fused_njit
def column_sums(scratch, matrix, rows, wide, out):
    """Write the column sums (wide) of a matrix (rows, wide), where rows is a multiple of ROWS: sum every
    fourth row, then add the four sums."""
    for c in range(0, wide, LANES):
        at = matrix + c
        y0, y1, y2, y3 = (
            load(scratch, at),
            load(scratch, at + wide),
            load(scratch, at + 2 * wide),
            load(scratch, at + 3 * wide),
        )
        for _ in range(ROWS, rows, ROWS):
            at += ROWS * wide
            y0, y1 = y0 + load(scratch, at), y1 + load(scratch, at + wide)
            y2, y3 = y2 + load(scratch, at + 2 * wide), y3 + load(scratch, at + 3 * wide)
        store(scratch, out + c, (y0 + y1) + (y2 + y3))
