"""The rows of tables: who comes into them, who leaves them, and what stands in them beyond its limits.

A kernel that takes many arrays spends more time on taking them than on using them, so columns come by their
addresses. These hold as long as no column is replaced; `Columns.replaced` says so.
"""

from typing import Any, NamedTuple

import numba
import numpy as np
from numba import carray, types
from numba.extending import intrinsic

from ecs_eco.engine.jit import njit

FEW = 32  # rows that are brought into order one by one


def address_of(array: np.ndarray) -> int:
    """Return where an array begins in memory."""
    return int(array.__array_interface__["data"][0])


def _as_pointer(typing: Any, address: Any, like: Any) -> Any:
    """Take an address as that of values of the type of the array `like`."""

    def make(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number, _ = arguments
        return builder.inttoptr(number, context.get_value_type(signature.return_type))

    return types.CPointer(like.dtype)(types.uint64, like), make  # type: ignore[no-untyped-call]


pointer: Any = intrinsic(_as_pointer)


class Defaults(NamedTuple):
    """Columns, and the value of each that newborn have unless they are given another."""

    made_from: tuple[Any, ...] = ()  # what they hold for
    others: tuple[tuple[type[Any], str], ...] = ()  # components and fields that have no addresses
    arrays: tuple[np.ndarray, ...] = ()  # they keep the addresses alive
    columns: np.ndarray = np.empty(0, np.uint64)  # addresses
    values: np.ndarray = np.empty(0, np.uint64)  # addresses
    size: np.ndarray = np.empty(0, np.int64)  # bytes of a row

    @classmethod
    def of(cls, made_from: tuple[Any, ...], columns: dict[type[Any], Any],
           defaults: dict[type[Any], dict[str, np.ndarray]]) -> "Defaults":
        """Make them of the columns of a table and the values that newborn have in these."""
        fields = [(c, f, vars(it)[f], value) for c, it in columns.items() for f, value in defaults[c].items()]
        compiled = not numba.config.DISABLE_JIT  # type: ignore[attr-defined]  # else there are no addresses
        plain = [compiled and type(array) is np.ndarray and array.dtype == value.dtype
                 for _, _, array, value in fields]
        pairs = [(array, value) for (_, _, array, value), has in zip(fields, plain, strict=True) if has]
        others = tuple((c, f) for (c, f, _, _), has in zip(fields, plain, strict=True) if not has)
        return cls(made_from, others, tuple(array for pair in pairs for array in pair),
                   np.array([address_of(array) for array, _ in pairs], np.uint64),
                   np.array([address_of(value) for _, value in pairs], np.uint64),
                   np.array([value.nbytes for _, value in pairs], np.int64))


@njit
def fill(rows, capacity, columns, values, size):
    """Write a value to some rows of each column, which has `capacity` rows, all by their addresses, in bytes.
    """
    words, bytes_ = np.empty(0, np.uint32), np.empty(0, np.uint8)
    for k in range(columns.size):
        n = size[k] // 4
        if n * 4 == size[k]:
            wide, given = (carray(pointer(columns[k], words), capacity * n),
                           carray(pointer(values[k], words), n))
            for row in rows:
                for i in range(n):
                    wide[row * n + i] = given[i]
        else:
            narrow, told = (carray(pointer(columns[k], bytes_), capacity * size[k]),
                            carray(pointer(values[k], bytes_), size[k]))
            for row in rows:
                for i in range(size[k]):
                    narrow[row * size[k] + i] = told[i]


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
    fill(rows, alive.size, columns, defaults, size)
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
