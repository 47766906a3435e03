"""Check the columns of all tables with one call per type, because the check may run in every tick.

The kernel takes the addresses of the columns, which are valid until a column is replaced; see
`engine.addresses`.
"""

from typing import Any, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.engine.addresses import address_of, column_at
from ecs_eco.engine.table import Table


class ColumnGroup(NamedTuple):
    """Columns of one type from any tables, with the limits of their values: arrays [k]."""

    arrays: tuple[np.ndarray, ...]  # flat; kept because only their addresses are used
    addresses: np.ndarray  # u64
    table: np.ndarray  # i64, index of each column's table
    each: np.ndarray  # i64, values per organism
    low: np.ndarray
    high: np.ndarray

    @classmethod
    def of(cls, entries: list[tuple[int, np.ndarray, Any, Any]]) -> "ColumnGroup":
        """Return the group of columns of one type, given as (index of the table, column, low, high)."""
        table, arrays, low, high = zip(*entries, strict=True)
        return cls(
            tuple(array.reshape(-1) for array in arrays),
            np.array([address_of(array) for array in arrays], np.uint64),
            np.array(table, np.int64),
            np.array([array[:1].size for array in arrays], np.int64),
            np.array(low, arrays[0].dtype),
            np.array(high, arrays[0].dtype),
        )

    def first_outside(self, start: int, rows: np.ndarray) -> int:
        """Return the index of the first column at or after `start` with NaN or a value outside low … high, or
        -1 if there is none; `rows` i64 is the number of rows of each table, including dead rows."""
        outside: int = _first_outside(self.addresses, self.table, self.each, self.low, self.high, start, rows)
        return outside


def rows_of(tables: tuple[Table, ...]) -> np.ndarray:
    """Return how many rows of each table are in use: i64[tables]."""
    return np.array([table.high for table in tables], np.int64)


@njit
def _first_outside(addresses, table, each, low, high, start, rows):
    for k in range(start, addresses.size):
        n = each[k] * rows[table[k]]
        column, least, most, outside = column_at(addresses[k], low, n), low[k], high[k], False
        for i in range(n):  # branch-free, so that it vectorizes
            outside |= not ((column[i] >= least) & (column[i] <= most))
        if outside:
            return k
    return -1
