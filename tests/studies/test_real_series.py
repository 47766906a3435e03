"""Measured series are read whole, and a value is inside of windows as it should be."""

import numpy as np
import pytest

from studies.real_series import SERIES, inside, longest, measured


@pytest.mark.parametrize("name", SERIES)
def test_a_measured_pair_is_read_with_as_many_samples_of_both(name):
    prey, predator = measured(name)
    assert len(prey) == len(predator) >= 12
    assert np.isfinite(prey).all()
    assert np.isfinite(predator).all()


def test_the_longest_stretch_without_gaps_is_taken():
    x = np.array([[1.0, 2], [np.nan, 3], [4, 5], [6, 7], [8, np.nan], [9, 9]])
    assert longest(x).tolist() == [[4, 5], [6, 7]]
    assert longest(x[2:4]).tolist() == [[4, 5], [6, 7]]


def test_lags_are_compared_around_the_circle():
    lags = [0.9, 0.95, 0.0, 0.05, 0.1]
    assert inside(lags, 0.02, "lag")[2]
    assert inside(lags, 0.98, "lag")[2]
    assert not inside(lags, 0.5, "lag")[2]
    assert not inside(lags, 0.5, "regularity")[0] > 0.1
    assert inside([0.2, 0.4], 0.3, "prey swing")[2]
    assert not inside([0.2, 0.4], 0.41, "prey swing")[2]
