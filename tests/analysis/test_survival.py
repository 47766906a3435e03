"""Survival statistics against published numbers."""

import numpy as np
import pytest

from ecs_eco.analysis.survival import (
    bootstrap_difference,
    difference_of_shares,
    kaplan_meier,
    log_rank,
    wilson,
)

# Remission of leukaemia in weeks, Freireich et al. 1963, the textbook example:
# with 6-mercaptopurine and with a placebo.
DRUG = [6, 6, 6, 7, 10, 13, 16, 22, 23, 6, 9, 10, 11, 17, 19, 20, 25, 32, 32, 34, 35]
RELAPSED = [True] * 9 + [False] * 12
PLACEBO = [1, 1, 2, 2, 3, 4, 4, 5, 5, 8, 8, 8, 8, 11, 11, 12, 12, 15, 17, 22, 23]


def test_the_curve_is_the_published_one() -> None:
    curve = kaplan_meier(DRUG, RELAPSED)
    assert curve.time.tolist() == [0, 6, 7, 10, 13, 16, 22, 23]
    assert curve.at_risk.tolist() == [21, 21, 17, 15, 12, 11, 7, 6]
    assert curve.survival == pytest.approx([1, 0.857, 0.807, 0.753, 0.690, 0.627, 0.538, 0.448], abs=5e-4)
    assert curve.median == 23
    # R's survival, conf.type = "log-log", at week 10 and 23
    assert (curve.low[3], curve.high[3]) == (pytest.approx(0.503, abs=2e-3), pytest.approx(0.889, abs=2e-3))
    assert (curve.low[7], curve.high[7]) == (pytest.approx(0.188, abs=2e-3), pytest.approx(0.680, abs=2e-3))


def test_the_log_rank_test_is_the_published_one() -> None:
    chi2, p = log_rank((DRUG, RELAPSED), (PLACEBO, [True] * 21))
    assert chi2 == pytest.approx(16.79, abs=0.01)
    assert p == pytest.approx(4.17e-5, rel=0.01)


def test_nobody_died_and_everybody_died() -> None:
    alive = kaplan_meier([5, 5], [False, False])
    assert alive.survival.tolist() == [1]
    assert np.isnan(alive.median)
    assert alive.mean(5) == 5
    dead = kaplan_meier([2, 4], [True, True])
    assert dead.survival.tolist() == [1, 0.5, 0]
    assert (dead.low[-1], dead.median, dead.mean(10)) == (0, 2, 3)
    assert np.isfinite([dead.low, dead.high]).all()
    assert log_rank(([5, 5], [False, False]), ([5], [False])) == (0.0, 1.0)
    assert log_rank(([0], [False]), ([3, 4], [True, True])) == (0.0, 1.0)


def test_two_equal_groups_do_not_differ() -> None:
    group = ([1, 2, 3, 4], [True, True, True, False])
    assert log_rank(group, group)[1] == pytest.approx(1)


def test_wilson_and_newcombe_give_the_published_intervals() -> None:
    # Newcombe 1998: 81 of 263, and 56 of 70 against 48 of 80
    assert wilson(81, 263) == pytest.approx((0.3080, 0.2553, 0.3662), abs=1e-4)
    assert difference_of_shares(56, 70, 48, 80) == pytest.approx((0.2, 0.0524, 0.3339), abs=1e-4)
    assert wilson(0, 6)[1:] == pytest.approx((0, 0.3903), abs=1e-4)
    assert wilson(0, 0)[1:] == (0, 1)


@pytest.mark.parametrize("paired", [True, False])
def test_a_bootstrap_interval_covers_about_as_often_as_it_says(paired: bool) -> None:
    rng, inside = np.random.default_rng(0), 0
    for i in range(200):
        a, b = rng.normal(1, 1, 10), rng.normal(0, 1, 10)
        estimate = bootstrap_difference(a, b, paired=paired, n_boot=499, seed=i)
        inside += estimate.low <= 1 <= estimate.high
    assert 0.89 <= inside / 200 <= 0.99


def test_pairing_removes_what_pairs_share() -> None:
    shared = np.array([1.0, 5, 9, 20])
    assert bootstrap_difference(shared + 1, shared, paired=True) == pytest.approx((1, 1, 1))
    loose = bootstrap_difference(shared + 1, shared)
    assert loose.low < -3


def test_misuse_names_the_value() -> None:
    with pytest.raises(ValueError, match=r"successes = 4; expected 0 to 3"):
        wilson(4, 3)
    with pytest.raises(ValueError, match="got -1"):
        kaplan_meier([1, -1], [True, True])
    with pytest.raises(ValueError, match="equally long, got 2 and 3"):
        bootstrap_difference([1, 2], [1, 2, 3], paired=True)
    with pytest.raises(ValueError, match=r"one-dimensional and equally long, got shapes \(2,\) and \(1,\)"):
        kaplan_meier([1, 2], [True])
