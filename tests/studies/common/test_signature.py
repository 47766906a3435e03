"""Signatures of cycles: known waves are measured, long series as short ones are sampled."""

import numpy as np
import pytest

from studies.common.signature import MEASURES, signature, windows


def wave(n, period, lag=0.0, swing=0.3, noise=0.0, seed=1):
    rng = np.random.default_rng(seed)
    x = np.sqrt(2) * swing * np.sin(2 * np.pi * (np.arange(n) / period - lag))
    return 10 ** (2 + x + noise * rng.standard_normal(n))


@pytest.mark.parametrize("lag", [0.0, 0.13, 0.25, 0.6])
def test_period_lag_and_swing_of_waves_are_found(lag):
    found = signature(wave(60, 10), wave(60, 10, lag, 0.6))
    assert found.period == pytest.approx(10, rel=0.03)
    assert found.lag == pytest.approx(lag, abs=0.01) or found.lag == pytest.approx(lag + 1, abs=0.01)
    assert found.regularity > 0.99
    assert found.prey_swing == pytest.approx(0.3, rel=0.05)
    assert found.predator_swing == pytest.approx(0.6, rel=0.05)
    assert set(MEASURES) < set(found.as_dict())


def test_noise_is_not_regular_and_has_any_lag():
    pairs = [
        signature(wave(21, 10, swing=0, noise=1, seed=i), wave(21, 10, swing=0, noise=1, seed=1000 + i))
        for i in range(200)
    ]
    assert np.mean([p.regularity for p in pairs]) < 0.5
    assert abs(np.exp(2j * np.pi * np.array([p.lag for p in pairs])).mean()) < 0.2


def test_units_and_trends_do_not_matter():
    x, y = wave(40, 8, noise=0.05), wave(40, 8, 0.2, noise=0.05, seed=2)
    growing = 10 ** (0.02 * np.arange(40))
    a, b = signature(x, y), signature(1000 * x * growing, y / 7)
    assert a.as_dict() == pytest.approx(b.as_dict())


def test_windows_of_a_long_series_are_sampled_as_a_short_one():
    prey, predator = wave(9000, 1000, noise=0.02), wave(9000, 1000, 0.25, noise=0.02, seed=3)
    found = windows(prey, predator, 20, 10.0)
    assert len(found) == 4  # two periods each
    assert [w.lag for w in found] == pytest.approx([0.25] * 4, abs=0.03)
    assert [w.period for w in found] == pytest.approx([10.0] * 4, rel=0.15)


def test_series_of_different_times_are_refused():
    with pytest.raises(ValueError, match="20 numbers of the prey, 19 of the predator"):
        signature(wave(20, 5), wave(19, 5))
