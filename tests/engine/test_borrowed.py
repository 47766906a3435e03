"""Kernels borrow arrays from Python only where they cannot keep them."""

import sys

import numpy as np
import pytest

from ecs_eco.compiled.jit import njit


@njit
def total(array, pair):
    return array.sum() + pair[0].sum() + pair[1]


@njit
def second_half(array):
    return array[array.size // 2 :]


@njit
def with_size(array):
    return array.size, array


@njit
def refuse(array):
    raise ValueError("no")


def test_a_kernel_reads_strided_and_read_only_arrays_and_those_of_a_tuple():
    wide = np.arange(12.0).reshape(3, 4)
    fixed = wide.copy()
    fixed.flags.writeable = False
    assert total(wide[:, 1], (fixed, 2.0)) == wide[:, 1].sum() + wide.sum() + 2


def test_a_call_leaves_as_many_references_as_there_were():
    array, pair = np.ones(3), (np.ones(2), 1.0)
    total(array, pair)
    before = sys.getrefcount(array), sys.getrefcount(pair[0])
    for _ in range(10):
        total(array, pair)
    with pytest.raises(ValueError, match="no"):
        refuse(pair[0])
    assert (sys.getrefcount(array), sys.getrefcount(pair[0])) == before


def test_an_array_that_a_kernel_returns_outlives_what_python_knew_of_it():
    for of in (second_half, lambda array: with_size(array)[1][2:]):
        kept = of(np.arange(4.0))
        others = [np.zeros(4) for _ in range(100)]  # which would get its memory
        assert kept.tolist() == [2, 3], others
