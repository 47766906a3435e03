"""The size and the power of the test for cycles, measured."""

import numpy as np
import pytest
from scipy.signal import lfilter

from ecs_eco.analysis.spectrum import detrend, smooth, spectral_peak, thin, transform


def red(roots: tuple[float, ...], n: int, rng: np.random.Generator) -> np.ndarray:
    """Red noise with these roots, started long before."""
    x = rng.standard_normal(n + 10_000)
    for root in roots:
        x = lfilter([1], [1, -root], x)
    return x[-n:]


def quasi_cycle(n: int, period: float, rng: np.random.Generator, memory: float = 2.0) -> np.ndarray:
    """A cycle kept going by noise, whose phase is forgotten within `memory` periods."""
    r = np.exp(-1 / (memory * period))
    return lfilter(
        [1],
        [1, -2 * r * np.cos(2 * np.pi / period), r * r],
        rng.standard_normal(n + int(10 * memory * period)),
    )[-n:]


def called(series: list[np.ndarray], null: str = "relaxation") -> float:
    peaks = [spectral_peak(x, how="none", null=null, n_boot=99, seed=i) for i, x in enumerate(series)]
    return float(np.mean([peak.p <= 0.05 for peak in peaks]))


@pytest.mark.slow
@pytest.mark.parametrize("null", ["relaxation", "ar1"])
def test_red_noise_is_called_periodic_in_about_five_percent(null: str) -> None:
    rng = np.random.default_rng(1)
    rates = {
        phi: called([red((phi,), 256, rng) for _ in range(100)], null) for phi in (0.5, 0.7, 0.9, 0.95, 0.99)
    }
    assert 0.02 <= np.mean(list(rates.values())) <= 0.09, rates
    assert max(rates.values()) <= 0.11, rates


@pytest.mark.slow
@pytest.mark.parametrize("null", ["relaxation", "ar1"])
def test_long_red_noise_that_is_thinned_is_called_periodic_in_about_five_percent(null: str) -> None:
    rng = np.random.default_rng(2)
    assert called([red((0.999,), 8192, rng) for _ in range(100)], null) <= 0.1


@pytest.mark.slow
@pytest.mark.parametrize("own", [0.0, 0.3])
def test_smooth_red_noise_deceives_the_ar1_null_only(own: float) -> None:
    """Births that fluctuate slowly, without and with births and deaths as noise of their own."""
    rng = np.random.default_rng(3)
    series = []
    for _ in range(60):
        kicks = red((0.97,), 1500, rng)
        series.append(lfilter([1], [1, -0.97], kicks + own * rng.standard_normal(1500) * kicks.std())[-512:])
    assert called(series) <= 0.12
    assert called(series, "ar1") >= 0.85


@pytest.mark.slow
def test_ten_quasi_cycles_are_found_with_their_period() -> None:
    rng = np.random.default_rng(4)
    series = [quasi_cycle(2000, 200, rng) for _ in range(60)]
    assert called(series) >= 0.85
    peaks = [spectral_peak(x, how="none", n_boot=19) for x in series]
    assert np.median([peak.period for peak in peaks]) == pytest.approx(200, rel=0.06)
    assert np.median([peak.n_periods for peak in peaks]) == pytest.approx(10, rel=0.06)
    assert np.mean([peak.recurs for peak in peaks]) >= 0.85


def counted(expected: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Numbers that fluctuate around these."""
    wobble = lfilter([1], [1, -0.9], 0.05 * rng.standard_normal(len(expected)))
    return rng.poisson(expected * np.exp(wobble)).astype(float)


def test_what_happens_once_or_dies_away_has_no_period() -> None:
    rng, t = np.random.default_rng(11), np.arange(1000)
    boom = 20 * np.exp(np.where(t < 100, 0.05 * t, 5 - 0.08 * (t - 100)).clip(-1))
    swing = 500 * np.exp(1.2 * np.sin(2 * np.pi * np.arange(2500) / 1250))
    ringing = 500 * np.exp(1.5 * np.exp(-t / 100) * np.cos(2 * np.pi * t / 100))
    for expected in (boom, boom[:300], swing, ringing):
        peaks = [spectral_peak(counted(expected, rng), n_boot=19) for _ in range(10)]
        assert [peak.recurs for peak in peaks] == [False] * 10


def test_a_steady_wave_is_held_as_often_as_it_has_periods_and_beyond_a_longer_one_it_is_not_named() -> None:
    t = np.arange(2000)
    steady = spectral_peak(np.sin(2 * np.pi * t / 100), how="none", n_boot=9)
    assert steady.held == pytest.approx(20, rel=0.05)
    assert steady.slower < 0.01
    rng = np.random.default_rng(12)
    upon = [
        spectral_peak(
            a * np.sin(2 * np.pi * t / 1900) + np.sin(2 * np.pi * t / 100) + 0.1 * rng.standard_normal(2000),
            how="none",
            n_boot=9,
        )
        for a in (0.5, 3.0)
    ]
    assert [peak.period for peak in upon] == pytest.approx([100, 100], rel=0.05)
    assert [peak.recurs for peak in upon] == [True, False]


def fisher_g(series: np.ndarray) -> tuple[float, float]:
    """Return Fisher's g (Fisher 1929) and its p against white noise, an upper bound that is exact to p²/2."""
    x = detrend(np.asarray(series, float))
    power = np.abs(np.fft.rfft(x))[1 : (len(x) - 1) // 2 + 1] ** 2
    m, g = len(power), power.max() / power.sum()
    return float(g), float(min(1.0, m * (1 - g) ** (m - 1)))


def test_white_noise_is_the_wrong_null_for_populations() -> None:
    rng = np.random.default_rng(5)
    drifting = [fisher_g(red((0.9,), 256, rng))[1] <= 0.05 for _ in range(100)]
    white = [fisher_g(rng.standard_normal(256))[1] <= 0.05 for _ in range(200)]
    assert np.mean(drifting) >= 0.8
    assert np.mean(white) <= 0.1


def test_the_same_seed_gives_the_same_p() -> None:
    x = quasi_cycle(500, 60, np.random.default_rng(6))
    first, again = (spectral_peak(x, how="none", n_boot=99, seed=7) for _ in range(2))
    assert first.p == again.p
    assert np.array_equal(first.limit, again.limit)


def test_scale_and_level_of_a_series_do_not_matter() -> None:
    x = quasi_cycle(500, 60, np.random.default_rng(6))
    first, again = (spectral_peak(y, how="none", n_boot=99) for y in (x, 1e4 + 1e3 * x))
    assert first.p == again.p
    assert first.period == pytest.approx(again.period)


@pytest.mark.parametrize("series", [np.ones(500), np.arange(50.0), np.zeros(0)])
def test_a_constant_or_short_series_has_no_peak(series: np.ndarray) -> None:
    assert spectral_peak(series) is None


def test_thinning_averages_blocks_and_drops_the_start() -> None:
    x, factor = thin(np.array([9.0, 1, 3, 5, 7]), samples=2)
    assert factor == 3
    assert x.tolist() == [5]
    assert thin(np.arange(4.0), 4)[0].tolist() == [0, 1, 2, 3]


def test_smoothing_averages_what_there_is_at_the_ends() -> None:
    assert smooth(np.array([0.0, 3, 6, 3]), 3).tolist() == [1.5, 3, 4, 4.5]
    assert smooth(np.array([2.0, 4]), 100).tolist() == [3, 3]


def test_an_unknown_transform_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ValueError, match='"log", "sqrt" or "none"'):
        transform(np.ones(3), "logg")
    with pytest.raises(ValueError, match="'ar1', 'relaxation'"):
        spectral_peak(np.random.default_rng(0).standard_normal(200), how="none", null="white")
