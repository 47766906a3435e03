"""Columns by address. A kernel with many array arguments would spend more time unpacking them than working,
so it takes a single array of their memory addresses instead.

Addresses are valid until a table, component or column is replaced, which changes `Noted.changes` and
`Columns.replaced`.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from operator import is_
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import carray, types
from numba.extending import intrinsic, overload

from ecs_eco.engine.noted import Noted
from ecs_eco.engine.schema import Columns

if TYPE_CHECKING:
    from llvmlite import ir
    from numpy.typing import DTypeLike

    from ecs_eco.compiled.vectors import CPUContext, Emit, Signature, Typing


def address_of(array: np.ndarray) -> int:
    """Return the address of an array's first value."""
    try:
        # four times as fast as numpy's method, but type checkers do not accept the array as a buffer
        return ctypes.addressof(ctypes.c_char.from_buffer(array))  # type: ignore[arg-type]
    except (TypeError, ValueError):  # empty, or read-only
        return int(array.__array_interface__["data"][0])


class Addresses:
    """The addresses of the columns that `find()` returns, in the same rows, with 0 for None. They are looked
    up again after an array is replaced."""

    def __init__(self, find: Callable[[], Sequence[Sequence[np.ndarray | None]]]) -> None:
        self.find = find
        self._made_from: tuple[Any, ...] = ()
        self._arrays: list[np.ndarray | None] = []  # keeps the arrays alive, so their memory is not reused
        self._found = np.empty((0, 0), np.uint64)

    def __call__(self) -> np.ndarray:
        """Return the current addresses, u64[rows, columns]."""
        if self._made_from != (current := (Noted.changes, Columns.replaced)):
            arrays = self.find()
            flat = [array for row in arrays for array in row]
            if len(flat) != len(self._arrays) or not all(map(is_, flat, self._arrays)):
                self._arrays = flat
                self._found = np.array(
                    [[0 if a is None else address_of(a) for a in row] for row in arrays], np.uint64
                )
            self._made_from = current
        return self._found


def column_at(
    address: int | np.integer, kind: np.ndarray | DTypeLike, n: int | np.integer | tuple[int, ...]
) -> np.ndarray:
    """Return the values at an address as an array; `n` is their number or the array's shape, and `kind` is
    their dtype or an array of that dtype."""
    made = np.dtype(kind.dtype if isinstance(kind, np.ndarray) else kind)  # used without compilation
    memory: Any = (ctypes.c_char * (made.itemsize * int(np.prod(n)))).from_address(int(address))
    return np.frombuffer(memory, made).reshape(n)


def _as_pointer(
    typing: Typing, address: types.Type, kind: types.Array | types.DType
) -> tuple[Signature, Emit]:
    """Cast an address to a pointer to values of a type."""

    def make(
        context: CPUContext, builder: ir.IRBuilder, signature: Signature, arguments: Sequence[ir.Value]
    ) -> ir.Value:
        number, _ = arguments
        return builder.inttoptr(number, context.get_value_type(signature.return_type))

    return types.CPointer(kind.dtype)(types.uint64, kind), make


_pointer: Any = intrinsic(_as_pointer)


@overload(column_at)
def _column_at(address, kind, n):
    return lambda address, kind, n: carray(_pointer(address, kind), n)
