"""Estimates and tests of selection, against populations of Wright and Fisher in which the truth is known."""

import numpy as np
import pytest
from scipy import stats

from ecs_eco.analysis.lineage import ALIVE, Lineage
from studies.common.selection import (
    deaths_by_age,
    equivalence,
    frequency_increment_test,
    increments,
    path_coefficient,
    poisson_interval,
    pooled,
    reappearances,
    selection_coefficient,
)


def wright_fisher(s, n, generations, start, rng):
    """Carriers in each generation of n haploids, where a carrier's fitness is 1 + s of the others'."""
    counts = [round(start * n)]
    for _ in range(generations):
        p = counts[-1] / n
        counts.append(rng.binomial(n, p * (1 + s) / (1 + p * s)))
    return np.array(counts)


# selection


def test_the_slope_of_the_logits_is_the_coefficient_by_hand():
    generation = np.array([0.0, 1, 2, 4])
    odds = np.exp(0.3 * generation)
    carriers, n = 1e6 * odds / (1 + odds), np.full(4, 1e6)
    assert selection_coefficient(carriers, n / 2, n, generation) == pytest.approx(0.3, abs=1e-5)
    assert selection_coefficient(n / 2, carriers, n, generation) == pytest.approx(-0.3, abs=1e-5)
    two = selection_coefficient([1, 3], [2, 2], [4, 4], [0, 2])
    assert two == pytest.approx((np.log(3.5 / 1.5) - np.log(1.5 / 3.5)) / 2)


def test_a_gene_that_dies_out_or_fixes_has_a_finite_coefficient():
    assert np.isfinite(selection_coefficient([5, 0], [5, 10], [10, 10], [0, 1]))


def test_samples_without_living_are_left_out_and_one_generation_says_nothing():
    whole = selection_coefficient([1, 3], [2, 2], [4, 4], [0, 2])
    assert selection_coefficient([1, 0, 3], [2, 0, 2], [4, 0, 4], [0, np.nan, 2]) == whole
    assert np.isnan(selection_coefficient([1, 3], [2, 2], [4, 4], [1, 1]))


def mutating(s, mutation, n, generations, start, rng, share=0.25):
    """Carriers, where a share of the letters is drawn anew in each generation besides."""
    counts = [round(start * n)]
    for _ in range(generations):
        p = counts[-1] / n
        p = p * (1 + s) / (1 + p * s)
        counts.append(rng.binomial(n, p + mutation * (share - p)))
    return np.array(counts)


def test_the_likelihood_of_a_path_by_hand():
    n, generation = np.array([100, 100, 100]), np.array([0.0, 2.0, 3.0])
    # dp 0.10, 0.15; pull 0.1 (0.25 − p) dt = −0.05, −0.035; p (1 − p) dt = 0.5, 0.24
    k = np.array([50, 60, 75])
    assert path_coefficient(k, n, generation, 0.1) == pytest.approx((0.15 + 0.185) / 0.74)
    assert np.isnan(path_coefficient(np.zeros(3), n, generation, 0.1))
    assert path_coefficient([50, 0, 60, 75], [100, 0, 100, 100], [0, np.nan, 2, 3], 0.1) == pytest.approx(
        (0.15 + 0.185) / 0.74
    )
    with pytest.raises(ValueError, match="from 0 to n"):
        path_coefficient([5, 3], [4, 4], [0, 1])


@pytest.mark.parametrize("s", [0.0, 0.1, 0.4])
def test_the_likelihood_of_a_path_says_the_same_of_a_longer_run_and_the_slope_does_not(s):
    rng, n = np.random.default_rng(11), 330
    paths = [(mutating(s, 0.01, n, 45, 0.25, rng), mutating(0, 0.01, n, 45, 0.25, rng)) for _ in range(200)]
    found, slopes = {}, {}
    for generations in (12, 24, 46):
        sizes, x = np.full(generations, n), np.arange(generations)
        found[generations] = np.mean([path_coefficient(k[:generations], sizes, x, 0.01) for k, _ in paths])
        slopes[generations] = np.mean(
            [selection_coefficient(k[:generations], r[:generations], sizes, x) for k, r in paths]
        )
    # in discrete generations dp = s p (1 - p) / (1 + s p): somewhat less than s
    assert all(0.75 * s - 0.015 <= value <= s + 0.015 for value in found.values()), found
    assert max(found.values()) - min(found.values()) < 0.12 * s + 0.015, found
    if s == 0.4:
        assert slopes[46] < 0.4 * slopes[12], slopes


@pytest.mark.parametrize("s", [-0.05, 0.0, 0.1])
def test_a_known_coefficient_is_recovered_from_drifting_populations(s):
    rng, n, generations = np.random.default_rng(3), 1000, 20
    coefficients = [
        selection_coefficient(
            wright_fisher(s, n, generations, 0.3, rng),
            wright_fisher(0, n, generations, 0.3, rng),
            np.full(generations + 1, n),
            np.arange(generations + 1),
        )
        for _ in range(200)
    ]
    low, high = pooled(coefficients).interval95
    assert low - 0.002 < np.log(1 + s) < high + 0.002
    assert high - low < 0.01


def test_pooled_intervals_cover_the_truth_as_often_as_they_say():
    rng = np.random.default_rng(4)
    covered = np.zeros(2)
    for _ in range(2000):
        estimate = pooled(rng.normal(1, 2, 7))
        covered += [low < 1 < high for low, high in (estimate.interval95, estimate.interval90)]
    assert np.abs(covered / 2000 - [0.95, 0.90]).max() < 0.02


def test_a_pool_by_hand():
    estimate = pooled([1.0, 2.0, 3.0])
    assert (estimate.n, estimate.mean) == (3, 2.0)
    assert estimate.interval95 == pytest.approx((2 - 4.302653 / np.sqrt(3), 2 + 4.302653 / np.sqrt(3)))
    assert estimate.interval90 == pytest.approx((2 - 2.919986 / np.sqrt(3), 2 + 2.919986 / np.sqrt(3)))
    assert np.isnan(pooled([1.0]).interval95).all()


# equivalence


def test_equivalence_is_the_interval_within_the_margin():
    rng = np.random.default_rng(5)
    for _ in range(300):
        values = rng.normal(rng.uniform(-0.1, 0.1), 0.05, 6)
        estimate = equivalence(values, 0.05)
        assert estimate.interval == pooled(values).interval90
        assert (
            estimate.equivalent
            == (estimate.interval[0] > -0.05 and estimate.interval[1] < 0.05)
            == (estimate.p < 0.05)
        )
        sides = (
            stats.ttest_1samp(values, -0.05, alternative="greater").pvalue,
            stats.ttest_1samp(values, 0.05, alternative="less").pvalue,
        )
        assert estimate.p == pytest.approx(max(sides))


@pytest.mark.slow
def test_at_the_margin_equivalence_is_claimed_in_one_of_twenty():
    rng = np.random.default_rng(6)
    claimed = np.mean([equivalence(rng.normal(0.05, 0.02, 10), 0.05).equivalent for _ in range(4000)])
    assert claimed == pytest.approx(0.05, abs=0.012)


def test_few_or_equal_runs():
    assert not equivalence([0.0], 0.05).equivalent
    assert equivalence([0.01, 0.01], 0.05).equivalent
    assert not equivalence([0.05, 0.05], 0.05).equivalent
    with pytest.raises(ValueError, match="the margin is 0; expected above 0"):
        equivalence([1.0, 2.0], 0)
    with pytest.raises(ValueError, match="expected one finite number per run"):
        pooled([1.0, np.nan])


# the frequency increment test


def test_increments_by_hand():
    increments_ = increments([0.5, 0.6, 0.36, 0.0, 0.2, 0.5], [0, 2, 3, 4, 5, 7])
    expected = [0.1 / np.sqrt(2 * 0.25 * 2), -0.24 / np.sqrt(2 * 0.24), 0.3 / np.sqrt(2 * 0.16 * 2)]
    assert increments_.tolist() == pytest.approx(expected)
    n, t, p = frequency_increment_test([0.5, 0.6, 0.36, 0.0, 0.2, 0.5], [0, 2, 3, 4, 5, 7])
    twin = stats.ttest_1samp(expected, 0)
    assert (n, t, p) == (3, pytest.approx(twin.statistic), pytest.approx(twin.pvalue))


def test_the_increment_test_rejects_neutral_drift_in_about_one_of_twenty():
    rng, x = np.random.default_rng(7), np.arange(0, 101, 5)
    tests = [
        frequency_increment_test(wright_fisher(0, 5000, 100, 0.5, rng)[::5] / 5000, x) for _ in range(1500)
    ]
    assert np.mean([test.p < 0.05 for test in tests]) == pytest.approx(0.05, abs=0.02)


def test_the_increment_test_finds_selection():
    rng, x = np.random.default_rng(8), np.arange(0, 41, 4)
    tests = [
        frequency_increment_test(wright_fisher(0.05, 2000, 40, 0.3, rng)[::4] / 2000, x) for _ in range(200)
    ]
    assert np.mean([test.p < 0.05 and test.t > 0 for test in tests]) > 0.9


def test_too_few_increments_say_nothing():
    assert frequency_increment_test([0.5, 0.6], [0, 1])[0] == 1
    assert np.isnan(frequency_increment_test([0.5, 0.6], [0, 1]).p)
    assert frequency_increment_test([0.0, 1.0, 0.0], [0, 1, 2]).n == 0
    with pytest.raises(ValueError, match="generations must ascend"):
        increments([0.5, 0.6, 0.7], [0, 1, 1])
    with pytest.raises(ValueError, match="expected shares from 0 to 1, got 3"):
        increments([0.5, 3.0], [0, 1])
    with pytest.raises(ValueError, match=r"share \(2,\), generation \(3,\)"):
        increments([0.5, 0.6], [0, 1, 2])


# what else is counted


@pytest.mark.parametrize(
    ("carriers", "times"),
    [
        ([0, 0, 3, 0, 0, 1, 2, 0, 4, 0], 2),
        ([3, 2, 1, 0], 0),
        ([0, 1, 1], 0),
        ([1, 0, 1], 1),
        ([], 0),
        ([0], 0),
    ],
)
def test_a_gene_reappears_after_it_had_none(carriers, times):
    assert reappearances(carriers) == times


def _lineage(born, died, cause, end=20, dt=0.5):
    n = len(born)
    none = np.zeros(n, np.uint64)
    return Lineage(
        np.arange(1, n + 1, dtype=np.uint64),
        none,
        none,
        np.full(n, "goat"),
        np.array(born),
        np.array(died),
        np.array(cause),
        np.full(n, "", object),
        end,
        dt,
    )


def test_deaths_are_counted_by_the_age_and_the_time_that_all_lived():
    # ages [s] 3, 9, 5 (alive), 2
    lineage = _lineage([0, 0, 10, 4], [6, 18, ALIVE, 8], ["poison", "poison", "", "starved"])
    rates = deaths_by_age(lineage, "poison", [0, 3, 10])
    assert rates.deaths.tolist() == [1, 1]
    assert rates.lived.tolist() == [3 + 3 + 3 + 2, 0 + 6 + 2 + 0]
    assert rates.rate.tolist() == [1 / 11, 1 / 8]
    low, high = poisson_interval(np.array([1, 1]))
    assert rates.low.tolist() == (low / [11, 8]).tolist()
    assert rates.high.tolist() == (high / [11, 8]).tolist()
    assert deaths_by_age(lineage, None, [0, 3, 10]).deaths.tolist() == [2, 1]
    assert deaths_by_age(lineage, "poison", [3, 9, 10]).deaths.tolist() == [1, 0]
    assert deaths_by_age(_lineage([5], [5], ["culled"]), None, [0, 1]).deaths.tolist() == [1]
    assert deaths_by_age(lineage, "poison", [0, 1], "goat").lived.tolist() == [4.0]


def test_a_class_that_nobody_reached_has_no_rate():
    rates = deaths_by_age(_lineage([0], [4], ["poison"]), "poison", [0, 2, 50, 60])
    assert rates.deaths.tolist() == [1, 0, 0]
    assert rates.rate[0] == 1 / 2
    assert np.isnan(rates.rate[1:]).all()
    with pytest.raises(ValueError, match="expected at least 2 edges in ascending order"):
        deaths_by_age(_lineage([0], [4], ["poison"]), "poison", [0, 0])


def test_poisson_intervals_are_exact():
    low, high = poisson_interval(np.array([0, 10]))
    assert (low[0], high[0]) == (0, pytest.approx(-np.log(0.025)))
    assert stats.poisson.sf(9, low[1]) == pytest.approx(0.025)
    assert stats.poisson.cdf(10, high[1]) == pytest.approx(0.025)


def test_a_rate_is_recovered_from_lives_cut_short_by_the_end():
    rng, n, rate = np.random.default_rng(9), 20_000, 0.02
    born = rng.integers(0, 400, n)
    age = np.ceil(rng.exponential(1 / rate, n)).astype(int)
    died = np.where(born + age <= 400, born + age, ALIVE)
    rates = deaths_by_age(
        _lineage(born, died, np.where(died < 0, "", "poison"), 400, 1.0), "poison", [0, 20, 100, 300]
    )
    per_tick = 1 - np.exp(-rate)
    assert (rates.low < per_tick).all()
    assert (rates.high > per_tick).all()
    assert (rates.high - rates.low < 0.01).all()
