import platform

import numba
import numpy as np
import pytest

from ecs_eco.compiled.vectors import LANES, load, store
from ecs_eco.learning.arithmetic import exp, fused_njit, log, tanh


@fused_njit
def _each_tanh(x, y):
    for i in range(0, len(x) - LANES + 1, LANES):
        store(y, i, tanh(load(x, i)))


@fused_njit
def _each_exp(x, y):
    for i in range(len(x)):
        y[i] = exp(x[i])


@fused_njit
def _each_log(x, y):
    for i in range(len(x)):
        y[i] = log(x[i])


def _of(kernel, x):
    x = np.append(x, np.ones(LANES, np.float32))  # whole vectors reach beyond the end
    y = np.empty_like(x)
    kernel(x, y)
    return y[:-LANES]


def test_tanh_is_exact_to_4e_7_and_never_beyond_one():
    x = np.linspace(-20, 20, 1_000_001).astype(np.float32)
    y = _of(_each_tanh, x)
    assert np.abs(y - np.tanh(x.astype(float))).max() < 4e-7
    assert np.abs(y).max() <= 1
    small = np.logspace(-30, -2, 1000).astype(np.float32)
    np.testing.assert_allclose(_of(_each_tanh, small), np.tanh(small.astype(float)), rtol=4e-7)
    assert np.isnan(_of(_each_tanh, np.array([np.nan], np.float32))[0])


def test_exp_is_exact_to_a_relative_2e_7_and_bounded():
    x = np.linspace(-87, 88, 1_000_001).astype(np.float32)
    np.testing.assert_allclose(_of(_each_exp, x), np.exp(x.astype(float)), rtol=2e-7)
    assert np.isfinite(_of(_each_exp, np.array([-1e30, 1e30], np.float32))).all()


def test_log_is_exact_to_2e_7():
    x = np.exp(np.linspace(-80, 80, 1_000_001)).astype(np.float32)
    right = np.log(x.astype(float))
    assert (np.abs(_of(_each_log, x) - right) / np.maximum(1, np.abs(right))).max() < 2e-7


@pytest.mark.parametrize("kernel", [_each_tanh, _each_exp, _each_log])
def test_result_does_not_depend_on_the_place_in_the_array(kernel):
    x = np.abs(np.random.default_rng(1).standard_normal(1001).astype(np.float32)) + np.float32(0.01)
    whole = _of(kernel, x)
    for start in range(1, 40):
        assert np.array_equal(_of(kernel, x[start:].copy()), whole[start:])


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="looks for an instruction of x86")
def test_loops_become_vectors():
    # cached code has none
    fresh = numba.njit(nogil=True, error_model="numpy", fastmath={"contract"})(_each_tanh.py_func)
    _of(fresh, np.zeros(LANES, np.float32))
    assert any("divps" in assembly for assembly in fresh.inspect_asm().values())
