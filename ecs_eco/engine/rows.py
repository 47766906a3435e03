"""The rows of tables: fill them with newborns, free them, and find values outside their limits."""

from collections.abc import Mapping, Sequence
from operator import is_
from typing import Any, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.engine.addresses import address_of, column_at
from ecs_eco.engine.schema import Columns

EIGHT_ALIVE = np.uint64(0x0101010101010101)  # bytes of `alive`
ROWS = "alive", "uid", "born", "cause", "killer"  # a table's own arrays, in the order that kernels expect


class Layout(NamedTuple):
    """The addresses of a table's arrays, and the default value of each column for newborns."""

    arrays: Sequence[np.ndarray] = ()  # keeps the arrays alive
    rows: np.ndarray = np.empty(0, np.uint64)  # addresses of ROWS
    columns: np.ndarray = np.empty(
        (3, 0), np.uint64
    )  # addresses of columns, addresses of defaults, bytes per row
    fields: dict[tuple[type[Any], str], Any] = {}  # the columns by component and field
    shapes: dict[tuple[type[Any], str], tuple[int, ...]] = {}  # bytes per value
    others: tuple[tuple[type[Any], str], ...] = ()  # components and fields that have no addresses

    def renewed(
        self,
        own: Sequence[np.ndarray],
        held: Mapping[type[Any], Columns],
        defaults: Mapping[type[Any], Mapping[str, np.ndarray]],
    ) -> "Layout":
        """Return the layout of a table, whose arrays ROWS are `own`: the same object if only arrays of other
        tables were replaced."""
        arrays = [*own]
        for component, columns in held.items():
            arrays += vars(columns).values()
            arrays += defaults[component].values()
        if len(arrays) == len(self.arrays) and all(map(is_, arrays, self.arrays)):
            return self
        values = {(c, f): value for c in held for f, value in defaults[c].items()}
        fields = {(c, f): vars(held[c])[f] for c, f in values}
        plain = [
            key
            for key, array in fields.items()
            if type(array) is np.ndarray and array.dtype == values[key].dtype
        ]
        places = [(address_of(fields[key]), address_of(values[key]), values[key].nbytes) for key in plain]
        return Layout(
            arrays,
            np.array([address_of(array) for array in own], np.uint64),
            np.array(places, np.uint64).reshape(-1, 3).T.copy(),
            fields,
            {key: value.shape for key, value in values.items()},
            tuple(key for key in fields if key not in plain),
        )


@njit
def fill(rows, capacity, columns):
    """Write one value per column to some rows; each column has `capacity` rows. `columns` u64[3, columns]
    contains the addresses of columns and values, and the bytes per row."""
    for k in range(columns.shape[1]):
        size = np.int64(columns[2, k])
        n = size // 4
        if n == 1 and size == 4:  # most columns; a nested loop would take four times as long
            flat = column_at(columns[0, k], np.uint32, capacity)
            value = column_at(columns[1, k], np.uint32, 1)[0]
            for row in rows:
                flat[np.uint64(row)] = value
        elif n * 4 == size:
            wide = column_at(columns[0, k], np.uint32, capacity * n)
            given = column_at(columns[1, k], np.uint32, n)
            for row in rows:
                for i in range(n):
                    wide[row * n + i] = given[i]
        else:
            narrow = column_at(columns[0, k], np.uint8, capacity * size)
            told = column_at(columns[1, k], np.uint8, size)
            for row in rows:
                for i in range(size):
                    narrow[row * size + i] = told[i]


@njit
def occupy(rows, capacity, own, first_uid, tick, high, columns):
    """Write the lowest free rows to `rows` and fill them with living entities that have the values in
    `columns`; return the new end of the rows in use. `own` u64 contains the addresses of ROWS."""
    alive, uid = column_at(own[0], np.bool_, capacity), column_at(own[1], np.uint64, capacity)
    born, row = column_at(own[2], np.int64, capacity), -1
    for k in range(rows.size):
        row = next_free(alive, row + 1, capacity)
        rows[k] = row
        alive[row] = True
        uid[row] = first_uid + k
        born[row] = tick
        high = max(high, row + 1)
    fill(rows, capacity, columns)
    return high


@njit
def next_free(alive, row, capacity):
    """Return the first free row at or after `row`; one must exist."""
    while row % 8 != 0 and alive[row]:
        row += 1
    if row % 8 == 0:  # eight at a time
        eight, k = alive[: capacity // 8 * 8].view(np.uint64), row // 8
        while k < eight.size and eight[k] == EIGHT_ALIVE:
            k += 1
        row = 8 * k
    while alive[row]:
        row += 1
    return row


@njit
def vacate(rows, capacity, own, high):
    """Free rows; return the new end of the rows in use, which is at most `high`."""
    alive, uid = column_at(own[0], np.bool_, capacity), column_at(own[1], np.uint64, capacity)
    cause, killer = column_at(own[3], np.uint8, capacity), column_at(own[4], np.uint64, capacity)
    for row in rows:
        alive[row], uid[row], cause[row], killer[row] = False, 0, 0, 0
    while high > 0 and not alive[high - 1]:
        high -= 1
    return high


@njit
def first_outside(columns, start, n, each, low, high):
    """Return the index of the first flat column at or after `start` with a value outside low … high, or -1 if
    there is none.

    Checks the first n * each[k] values of column k, including dead rows.
    """
    for k in range(start, len(columns)):
        column, least, most, outside = columns[k], low[k], high[k], False
        for i in range(n * each[k]):  # no branches, so that this loop is vectorized
            outside |= not ((column[i] >= least) & (column[i] <= most))
        if outside:
            return k
    return -1
