"""The rows of tables: who comes into them, who leaves them, and what stands in them beyond its limits."""

import numpy as np

from ecs_eco.engine.addresses import fill
from ecs_eco.engine.jit import njit

FEW = 32  # rows that are brought into order one by one


@njit
def occupy(rows, alive, uid, born, first_uid, tick, high, columns, defaults, size):
    """Fill `rows` with the lowest free rows and bring them to life, with defaults in the columns at these
    addresses; return the new end of the rows in use."""
    taken = 0
    for row in range(alive.size):
        if taken == rows.size:
            break
        if not alive[row]:
            rows[taken] = row
            alive[row] = True
            uid[row] = first_uid + taken
            born[row] = tick
            taken += 1
            high = max(high, row + 1)
    fill(rows, columns, defaults, size)
    return high


@njit
def list_dying(cause, uid, rows):
    """List the rows with a cause of death, few of them in the order of uids; return their number."""
    n, whole = 0, rows.size // 8
    eight = cause[: 8 * whole].view(np.uint64)
    for k in range(whole + 1):
        if k < whole and eight[k] == 0:
            continue
        for row in range(8 * k, min(8 * k + 8, rows.size)):
            if cause[row]:
                rows[n] = row
                n += 1
    for i in range(1, n if n <= FEW else 0):
        row, j = rows[i], i
        while j > 0 and uid[rows[j - 1]] > uid[row]:
            rows[j] = rows[j - 1]
            j -= 1
        rows[j] = row
    return n


@njit
def vacate(rows, alive, uid, cause, killer, high):
    """Free rows; return the new end of the rows in use."""
    for row in rows:
        alive[row] = False
        uid[row] = 0
        cause[row] = 0
        killer[row] = 0
    while high > 0 and not alive[high - 1]:
        high -= 1
    return high


@njit
def first_outside(columns, start, n, each, low, high):
    """Return the number of the first flat column, from `start` on, with a value outside low … high;
    -1 if there is none.

    Of column k the first n * each[k] values are checked, those of dead rows too.
    """
    for k in range(start, len(columns)):
        column, least, most, outside = columns[k], low[k], high[k], False
        for i in range(n * each[k]):  # without branches: this becomes vector code
            outside |= not ((column[i] >= least) & (column[i] <= most))
        if outside:
            return k
    return -1
