"""Cycles of short series: known waves are measured, bad ones refused."""

import numpy as np
import pytest

from ecs_eco.analysis.signature import cycle, logarithms, period_of, spectrum


def wave(n, period, lag=0.0, swing=0.3, noise=0.0, seed=1):
    rng = np.random.default_rng(seed)
    x = np.sqrt(2) * swing * np.sin(2 * np.pi * (np.arange(n) / period - lag))
    return 10 ** (2 + x + noise * rng.standard_normal(n))


def test_zeros_count_as_half_of_the_smallest():
    x = np.array([0.0, 2.0, 2.0, 0.0] * 4)
    assert np.ptp(logarithms(x)) == pytest.approx(np.log10(2))


@pytest.mark.parametrize(
    ("prey", "predator", "words"),
    [
        (np.zeros(20), wave(20, 5), "all numbers are 0"),
        (np.where(np.arange(20) == 3, np.nan, 1.0), wave(20, 5), "sample 3 is nan"),
        (-wave(20, 5), wave(20, 5), "0 or more"),
        (wave(11, 5), wave(11, 5), "at least 12 numbers"),
    ],
)
def test_what_cannot_be_measured_is_refused(prey, predator, words):
    with pytest.raises(ValueError, match=words):
        cycle(prey, predator)


def test_one_series_alone_has_a_period():
    assert period_of(wave(114, 9.6, noise=0.1)) == pytest.approx(9.6, rel=0.03)


def test_a_spectrum_is_highest_at_the_cycle_and_several_series_share_one():
    x, y, z = (wave(60, 12, lag, noise=0.05, seed=i) for i, lag in enumerate((0.0, 0.25, 0.6)))
    frequency, share = spectrum(x)
    assert 1 / frequency[share.argmax()] == pytest.approx(cycle(x).period)
    assert frequency[0] * 60 >= 1.5
    assert frequency[-1] <= 1 / 3
    found = cycle(x, y, z)
    assert found.period == pytest.approx(12, rel=0.03)
    assert found.phases == pytest.approx([0.0, 0.25, 0.6], abs=0.03)
