"""Lags with known answers, their intervals, and surrogates from other runs."""

import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from ecs_eco.analysis.cycles import (
    consumers,
    cross_correlation,
    cross_seed_surrogates,
    cycle_statistics,
    lag,
    living_stretch,
    median_lag_interval,
)
from ecs_eco.analysis.runs import Series, load_series

chains = SimpleNamespace(**runpy.run_path(str(Path(__file__).with_name("chains.py"))))
quasi_cycle = runpy.run_path(str(Path(__file__).with_name("test_spectrum.py")))["quasi_cycle"]
NAMES = chains.SPECIES


def of(numbers: np.ndarray) -> dict[str, np.ndarray]:
    return dict(zip(NAMES, numbers.T, strict=True))


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5, 0.9])
def test_the_lag_of_a_shifted_wave_is_the_shift(share: float) -> None:
    t = np.arange(3000)
    a, b = np.sin(2 * np.pi * t / 150), np.sin(2 * np.pi * (t / 150 - share))
    estimate = lag(a, b, 150)
    assert abs((estimate.share - share + 0.5) % 1 - 0.5) < 0.01
    assert estimate.coherence > 0.99
    assert estimate.high - estimate.low < 0.02


def test_an_interval_of_the_lag_covers_it_and_is_not_blown_up() -> None:
    rng, period, true, inside, widths = np.random.default_rng(0), 100, 0.27, 0, []
    for i in range(150):
        shared, own = quasi_cycle(1100, period, rng), quasi_cycle(1000, period, rng, 1.0)
        a, b = shared[27:1027], shared[:1000] + 0.5 * own * shared.std() / own.std()
        estimate = lag(a, b, period, n_boot=199, seed=i)
        inside += estimate.low <= true <= estimate.high
        widths.append(estimate.high - estimate.low)
    assert 0.85 <= inside / 150 <= 0.99
    assert np.median(widths) < 0.25


def test_a_median_of_lags_goes_around_the_circle() -> None:
    interval = median_lag_interval([0.95, 0.97, 0.99, 0.01, 0.03, 0.05])
    assert min(interval["median"], 1 - interval["median"]) < 0.011
    assert (interval["high"] - interval["low"]) == pytest.approx(0.10)
    assert interval["coverage"] == pytest.approx(1 - 2 / 64)


def test_a_median_of_lags_uses_inner_order_statistics_when_seeds_suffice() -> None:
    interval = median_lag_interval(np.linspace(0.2, 0.3, 11))
    assert interval["median"] == pytest.approx(0.25)
    assert (interval["low"], interval["high"]) == (pytest.approx(0.21), pytest.approx(0.29))
    assert interval["coverage"] >= 0.95
    assert median_lag_interval([])["n"] == 0
    assert median_lag_interval([0.3])["coverage"] == 0


def test_the_cross_correlation_peaks_where_b_follows() -> None:
    x = np.random.default_rng(0).standard_normal(500)
    lags, r = cross_correlation(x[7:], x[:-7], 20)
    assert lags[r.argmax()] == 7
    assert r.max() > 0.9


def test_a_chain_has_the_lags_it_was_made_with() -> None:
    statistics = cycle_statistics(of(chains.chain(4000, seed=1)))
    assert statistics.enough
    assert statistics.cycling() == NAMES
    assert statistics.period == pytest.approx(250, rel=0.15)
    for pair, true in (("grass→deer", 0.35), ("deer→wolf", 0.28), ("grass→wolf", 0.63)):
        assert statistics.lags[pair].share == pytest.approx(true, abs=0.04)
    assert statistics.as_dict()["peaks"]["deer"]["p"] <= 0.01


@pytest.mark.slow
def test_populations_that_drift_do_not_cycle() -> None:
    called = 0
    for seed in range(20):
        kicks = 0.02 * np.random.default_rng(seed).standard_normal((3000, 3))
        drift = np.zeros(3)
        numbers = np.array([np.exp(5 + (drift := 0.99 * drift + kick)) for kick in kicks])
        called += "deer" in cycle_statistics(of(numbers), n_boot=99).cycling()
    assert called <= 4


def test_the_series_is_read_up_to_the_first_extinction() -> None:
    numbers = chains.chain(3000)
    numbers[2000:, 2] = 0
    assert len(living_stretch(load_series(of(numbers)), 0.1)) == 1700
    assert cycle_statistics(of(numbers), n_boot=19).ticks == 1700


def test_a_short_run_is_said_to_be_short() -> None:
    statistics = cycle_statistics(of(chains.chain(90)))
    assert not statistics.enough
    assert statistics.cycling() == ()


def test_a_species_that_never_was_or_never_changes_is_no_trouble() -> None:
    numbers = chains.chain(1000)
    numbers[:, 2] = 0
    assert cycle_statistics(of(numbers), n_boot=19).species == ("grass", "deer")
    numbers[:, 2] = 7
    statistics = cycle_statistics(of(numbers), n_boot=19)
    assert statistics.peaks["wolf"] is None
    assert list(statistics.lags) == ["grass→deer"]


def test_species_can_be_chosen_and_ordered_and_misspelt_ones_are_named() -> None:
    run = of(chains.chain(1000))
    assert list(cycle_statistics(run, ("wolf", "deer"), n_boot=19).lags) == ["wolf→deer"]
    with pytest.raises(KeyError, match="did you mean 'deer'"):
        load_series(run, ("der",))


def test_surrogates_tell_coupled_species_from_uncoupled_ones() -> None:
    real = [chains.chain(3000, seed) for seed in range(6)]
    surrogates = cross_seed_surrogates([of(n) for n in real], "deer", "wolf")
    assert surrogates.p < 0.01
    assert surrogates.share == pytest.approx(0.28, abs=0.03)
    assert surrogates.real[:, surrogates.lags > 0].max() > surrogates.high.max()


def test_surrogates_hold_their_size() -> None:
    rng, called = np.random.default_rng(0), 0
    for _ in range(100):
        waves = [np.exp(5 + quasi_cycle(1500, 150, rng) * 0.01) for _ in range(10)]
        runs = [{"deer": waves[2 * i], "wolf": waves[2 * i + 1]} for i in range(5)]
        called += cross_seed_surrogates(runs, "deer", "wolf", 150).p <= 0.05
    assert called <= 11


def test_surrogates_want_four_runs_and_two_periods() -> None:
    runs = [of(chains.chain(300, seed)) for seed in range(4)]
    with pytest.raises(ValueError, match="at least 4 runs, got 3"):
        cross_seed_surrogates(runs[:3], "deer", "wolf")
    with pytest.raises(ValueError, match="fewer than two periods"):
        cross_seed_surrogates(runs, "deer", "wolf", 200)


FOOD = {"grass": [], "deer": ["grass"], "wolf": ["deer", "carrion"]}
DIETS = {"species": {name: {"diet": [{"eats": food} for food in foods]} for name, foods in FOOD.items()}}


def test_the_period_is_that_of_the_consumers_where_it_is_known_who_eats_whom() -> None:
    """Grass that beats clearly and fast by itself does not set the period of deer and wolves."""
    t, rng = np.arange(4000), np.random.default_rng(5)
    wave, beat = quasi_cycle(4000, 300, rng), 0.8 * np.sin(2 * np.pi * t / 60)
    wave /= wave.std()
    columns = np.stack([beat, 0.3 * wave, 0.3 * np.roll(wave, 75)], 1) + 0.02 * rng.standard_normal((4000, 3))
    numbers = {"n": np.round(500 * np.exp(columns))}
    blind, statistics = (
        cycle_statistics(Series(t, NAMES, numbers, manifest), n_boot=99)
        for manifest in ({}, {"config": DIETS})
    )
    assert (blind.period_of, statistics.period_of) == (NAMES, ("deer", "wolf"))
    assert blind.period == pytest.approx(60, rel=0.03)
    assert statistics.period == pytest.approx(300, rel=0.1)
    assert statistics.lags["deer→wolf"].share == pytest.approx(0.25, abs=0.04)
    chosen = cycle_statistics(of(numbers["n"]), n_boot=99, period_of=("wolf",))
    assert (chosen.period_of, chosen.period) == (("wolf",), statistics.peaks["wolf"].period)
    with pytest.raises(KeyError, match="did you mean 'wolf'"):
        cycle_statistics(of(numbers["n"]), period_of=("wolfs",))


def test_consumers_are_those_that_eat_another_species() -> None:
    assert consumers(DIETS) == ("deer", "wolf")
    assert consumers({}) == ()
    assert (
        consumers(
            {"species": {"pike": {"diet": [{"eats": "pike"}]}, "crab": {"diet": [{"eats": "carrion"}]}}}
        )
        == ()
    )
