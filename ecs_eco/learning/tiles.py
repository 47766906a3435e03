"""Matrix products with sums in registers, for networks of single animals.

Matrices lie in one flat array, and are named by the places where they begin: of every slice numba counts, in
atomic steps, who holds it.
"""

from __future__ import annotations

from ecs_eco.engine.vectors import LANES, every, load, store
from ecs_eco.learning.arithmetic import fused_njit

ROWS = 4  # of a tile: with two registers each, as many sums as AVX2 has to have under way at once


@fused_njit
def up(n, multiple):
    """Return the least multiple that is no less than n."""
    return (n + multiple - 1) // multiple * multiple


@fused_njit
def product(room, x, step_row, step, rows, matrix, step_matrix, n, bias, out, step_out, columns):
    """Write out (rows, columns) = bias (columns) + x · matrix (n, columns), in tiles of ROWS rows and LANES
    columns.

    Number k of row r of x is at x + r * step_row + k * step of the room f32[…], row k of the matrix at
    matrix + k * step_matrix, row r of the result at out + r * step_out. Tiles go beyond the rows and columns:
    what they read there is let be, what they write there comes before what belongs there; behind the last
    row, up to ROWS - 1 rows and LANES numbers are lost. Each number is the sum in the order of k, whatever
    the others are.
    """
    for c in range((columns - 1) // LANES * LANES, -1, -LANES):
        for r in range(0, rows, ROWS):
            at, k, to, y0 = x + r * step_row, matrix + c, out + r * step_out + c, load(room, bias + c)
            y1 = y2 = y3 = y0
            for _ in range(n):
                w = load(room, k)
                y0 = y0 + every(room, at) * w
                y1 = y1 + every(room, at + step_row) * w
                y2 = y2 + every(room, at + 2 * step_row) * w
                y3 = y3 + every(room, at + 3 * step_row) * w
                at += step
                k += step_matrix
            store(room, to, y0)
            store(room, to + step_out, y1)
            store(room, to + 2 * step_out, y2)
            store(room, to + 3 * step_out, y3)


@fused_njit
def column_sums(room, matrix, rows, wide, out):
    """Write the sums (wide) of the columns of a matrix (rows, wide), rows a multiple of ROWS: of every fourth
    row first, then these."""
    for c in range(0, wide, LANES):
        at = matrix + c
        y0, y1, y2, y3 = (
            load(room, at),
            load(room, at + wide),
            load(room, at + 2 * wide),
            load(room, at + 3 * wide),
        )
        for _ in range(ROWS, rows, ROWS):
            at += ROWS * wide
            y0, y1 = y0 + load(room, at), y1 + load(room, at + wide)
            y2, y3 = y2 + load(room, at + 2 * wide), y3 + load(room, at + 3 * wide)
        store(room, out + c, (y0 + y1) + (y2 + y3))
