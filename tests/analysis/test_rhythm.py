"""Cosines fitted to known waves, and days told from days begun at random hours."""

import numpy as np
import pytest

from ecs_eco.analysis.rhythm import cosinor, p_of_days


def test_a_cosine_is_found_again():
    t = np.arange(0, 600, 7)
    fit = cosinor(t, 12 + 5 * np.cos(2 * np.pi * (t - 40) / 200), 200)
    assert (fit.mesor, fit.amplitude, fit.acrophase) == pytest.approx((12, 5, 2 * np.pi * 40 / 200))


def test_four_values_by_hand():
    fit = cosinor([0, 1, 2, 3], [3, 1, 1, 3], 4)  # cosine: (3 − 1)/2 = 1, sine: (1 − 3)/2 = −1
    assert (fit.mesor, fit.amplitude, fit.acrophase) == pytest.approx((2, np.sqrt(2), 7 * np.pi / 4))


def test_days_alike_are_told_from_days_apart():
    hours = np.arange(24)
    alike = np.stack([np.cos(2 * np.pi * hours / 24)] * 8)
    assert p_of_days(alike) < 0.001
    rng = np.random.default_rng(4)
    apart = [
        np.stack([np.cos(2 * np.pi * (hours - rng.integers(24)) / 24) for _ in range(8)]) for _ in range(200)
    ]
    assert 0.02 <= np.mean([p_of_days(days, n=199, seed=i) <= 0.05 for i, days in enumerate(apart)]) <= 0.1


def test_a_drift_makes_no_days():
    rng, low = np.random.default_rng(5), 0
    for i in range(60):
        noise = np.zeros(20 * 48)
        for t in range(1, noise.size):
            noise[t] = 0.98 * noise[t - 1] + rng.normal(0, 0.2)
        low += p_of_days((noise + np.linspace(0, 15, noise.size)).reshape(20, 48), n=199, seed=i) <= 0.01
    assert low <= 4  # 1 in 100 by chance
