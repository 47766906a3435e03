"""Kernels for Python and for other kernels."""

import gc

import numpy as np
import pytest

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.kernel import Inner, Kernel
from ecs_eco.compiled.numba_version import plain

pytestmark = pytest.mark.skipif(plain(), reason="public numba compiles")


@njit
def double(x):
    return 2 * x


TREBLE = """
@njit
def treble(x):
    return 3 * x


@njit
def treble_of(x):
    return treble(x)
"""


@njit
def sum_of_doubles(array):
    total = 0.0
    for i in range(len(array)):
        total += double(array[i])
    return total


@njit
def fail(x):
    return x.nothing


def test_a_kernel_that_a_kernel_calls_is_compiled_for_it_alone_and_for_python_when_python_calls():
    room = {"njit": njit}
    exec(TREBLE, room)  # without a file: what another process has compiled is not found on disk
    treble, treble_of = room["treble"], room["treble_of"]
    assert treble_of(4.0) == 12
    assert isinstance(treble, Kernel)
    assert isinstance(treble.inner, Inner)
    assert len(treble.inner.signatures) == 1
    assert not treble.signatures
    assert treble(3.0) == 9
    assert len(treble.signatures) == 1


def test_first_calls_are_noted_with_their_types():
    before = len(Kernel.calls)
    values = np.arange(3, dtype=np.float32), np.arange(3, dtype=np.float32)
    for array in values:
        sum_of_doubles(array)
    ((kernel, signature),) = Kernel.calls[before:]
    assert kernel is sum_of_doubles
    assert str(signature[0]) == "array(float32, 1d, C)"


def test_collections_go_on_after_a_kernel_was_compiled_or_refused():
    assert gc.isenabled()
    double(1.5)
    with pytest.raises(Exception, match="nothing"):
        fail(1)
    assert gc.isenabled()
    gc.disable()
    try:
        double(np.float32(1))
        assert not gc.isenabled()
    finally:
        gc.enable()
