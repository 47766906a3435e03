"""Sine and cosine of many numbers at once."""

import numpy as np
import pytest

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.trigonometry import sine_and_cosine


@njit
def _each(x, sine, cosine):
    for i in range(len(x)):
        sine[i], cosine[i] = sine_and_cosine(x[i])


def _both(x):
    sine, cosine = np.empty((2, len(x)), np.float32)
    _each(x, sine, cosine)
    return sine, cosine


@pytest.mark.parametrize("most", [np.pi, 7, 100])
def test_they_are_numpys_to_the_precision_of_float32(most):
    x = np.linspace(-most, most, 200_001, dtype=np.float32)
    sine, cosine = _both(x)
    assert np.abs(sine - np.sin(x.astype(float))).max() < 2e-7
    assert np.abs(cosine - np.cos(x.astype(float))).max() < 2e-7


def test_quarters_of_a_turn_and_small_angles():
    x = (np.arange(9) * np.pi / 2).astype(np.float32)
    sine, cosine = _both(x)
    np.testing.assert_allclose(sine, [0, 1, 0, -1, 0, 1, 0, -1, 0], atol=2e-6)  # x itself is rounded
    np.testing.assert_allclose(cosine, [1, 0, -1, 0, 1, 0, -1, 0, 1], atol=2e-6)
    small = np.float32([0, 1e-30, -1e-7, 1e-4])
    assert np.array_equal(_both(small)[0], small) or np.allclose(_both(small)[0], small, rtol=1e-7)


def test_a_result_does_not_depend_on_the_place_in_the_array():
    x = np.random.default_rng(1).uniform(0, 6.3, 1001).astype(np.float32)
    whole = _both(x)
    for start in range(1, 40):
        assert all(
            np.array_equal(part, all_[start:])
            for part, all_ in zip(_both(x[start:].copy()), whole, strict=True)
        )
