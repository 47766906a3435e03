"""Kernels count references only to the arrays that they create."""

import gc
import weakref
from typing import Any, NamedTuple

import numba
import numpy as np
import pytest

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.numba_version import plain

pytestmark = pytest.mark.skipif(plain(), reason="public numba counts all references")


class Herd(NamedTuple):
    """Positions and masses."""

    x: np.ndarray
    mass: np.ndarray


@njit
def total(herd: Herd, n: int) -> float:
    """Return the sum of the products of position and mass, read from the named tuple in a loop."""
    sum_ = 0.0
    for i in range(n):
        sum_ += herd.x[i] * herd.mass[i]
    return sum_


@njit
def rest(herd: Herd, n: int) -> np.ndarray:
    """Return a part of an argument."""
    return herd.x[n:]


@njit
def either(herd: Herd, new: bool) -> np.ndarray:
    """Return an argument or a new array."""
    if new:
        return herd.x * 2.0
    return herd.x


@njit
def pair(n: int) -> Herd:
    """Return a named tuple of new arrays."""
    return Herd(np.ones(n), np.full(n, 2.0))


@njit
def all_together(herd: Herd, rows: np.ndarray, rounds: int) -> float:
    """Use new arrays, arguments, copies and parts in a loop, and return a sum."""
    sum_ = 0.0
    for k in range(rounds):
        made = pair(rows.size)
        chosen = either(herd, k % 2 == 0)[rows]
        kept = herd.mass if k % 3 == 0 else made.mass
        sum_ += (
            chosen.sum()
            + kept[: rows.size].sum()
            + rest(made, 1).sum()
            + total(Herd(made.x, kept), rows.size)
        )
    return sum_


@njit
def replaced(arrays: Any) -> float:
    """Take an array out of a list, replace it there, create others, and return the sum of the first."""
    first = arrays[0]
    arrays[0] = np.full(first.size, -1.0)
    others = np.full(first.size, -2.0)
    return float(first.sum()) + 0.0 * others[0]


LOOP = """
@njit
def sum_of(herd: Herd, n):
    sum_ = 0.0
    for i in range(n):
        if herd.mass[i] > 0:
            sum_ += herd.x[i] * herd.mass[i]
    return sum_
"""


def some(n: int) -> Herd:
    """Return n positions and masses."""
    return Herd(np.arange(n) + 0.0, np.full(n, 3.0))


def expected(herd: Herd, rows: np.ndarray, rounds: int) -> float:
    """Return the result of `all_together`, by numpy."""
    sum_ = 0.0
    for k in range(rounds):
        kept = herd.mass if k % 3 == 0 else np.full(rows.size, 2.0)
        sum_ += herd.x[rows].sum() * (2 if k % 2 == 0 else 1) + 2 * kept[: rows.size].sum() + rows.size - 1
    return sum_


def test_a_kernel_that_creates_nothing_counts_nothing() -> None:
    names: dict[str, Any] = {"Herd": Herd, "njit": njit}
    exec(LOOP, names)  # without a file, it is never cached
    assert names["sum_of"](some(5), 5) == 30.0
    (code,) = names["sum_of"].on_fields.inspect_llvm().values()
    assert "fmul" in code
    assert "call void @NRT_incref" not in code


def test_a_returned_part_of_an_argument_outlives_it() -> None:
    herd = some(1000)
    part, same = rest(herd, 400), either(herd, False)
    del herd
    gc.collect()
    filler = [np.full(1000, -1.0) for _ in range(50)]
    np.testing.assert_array_equal(part, np.arange(400, 1000))
    np.testing.assert_array_equal(same, np.arange(1000))
    assert len(filler) == 50


def test_created_arrays_are_freed_and_arguments_are_not() -> None:
    from numba.core.runtime import _nrt_python as runtime

    runtime.memsys_enable_stats()
    herd, rows = some(8), np.array([1, 4, 6])
    assert all_together(herd, rows, 12) == expected(herd, rows, 12)
    before = runtime.memsys_get_stats_alloc() - runtime.memsys_get_stats_free()
    for _ in range(20):
        all_together(herd, rows, 12)
    assert runtime.memsys_get_stats_alloc() - runtime.memsys_get_stats_free() == before
    np.testing.assert_array_equal(herd.x, np.arange(8))
    np.testing.assert_array_equal(herd.mass, np.full(8, 3.0))


def test_an_array_that_its_list_drops_lives_until_the_kernel_is_done() -> None:
    array = np.full(1000, 3.0)
    dropped, arrays = weakref.ref(array), numba.typed.List([array])
    del array
    gc.collect()
    assert dropped() is not None
    assert replaced(arrays) == 3000.0
    gc.collect()
    assert dropped() is None
