"""Values that all rows share or that differ by row, accessed in the same way in kernels (@njit).

A kernel that receives a number is compiled for numbers; a kernel that receives an array reads its rows.
Worlds in which all organisms share a value therefore pay nothing for individual values.
"""

from typing import Any, TypeAlias

import numpy as np
from numba import types
from numba.extending import overload

Number: TypeAlias = float | np.floating | np.ndarray  # one value for all rows, or [rows]


def of_row(value: Number, row: int | np.integer | np.ndarray) -> Any:
    """Return the value of a row: an entry of an array [rows], or the number itself."""
    return value[row] if isinstance(value, np.ndarray) else value


def row_of(values: np.ndarray, row: int | np.integer) -> np.ndarray:
    """Return the numbers of a row: a row of an array [rows, k], or the array [k] itself."""
    return values[row] if values.ndim == 2 else values


def is_own(value: object) -> bool:
    """Return whether each row has a separate value."""
    return isinstance(value, np.ndarray)


@overload(is_own)
def _is_own(value):
    own = isinstance(value, types.Array)
    return lambda value: own


@overload(of_row)
def _of_row(value, row):
    if isinstance(value, types.Array):
        return lambda value, row: value[row]
    return lambda value, row: value


@overload(row_of)
def _row_of(values, row):
    if values.ndim == 2:
        return lambda values, row: values[row]
    return lambda values, row: values
