"""Two classic experiments: their statistics on numbers counted by hand."""

import numpy as np
import pytest

from studies import fishing_for_size, rapid_evolution


def run(arm, seed, **result):
    return {"case": {"arm": arm, "seed": seed}, "result": result}


def test_only_cycles_with_a_lag_nearer_to_a_half_than_to_a_quarter_are_near_antiphase():
    lags = [0.25, 0.37, 0.38, 0.5, 0.62, 0.63, None]
    cases = [run("clones", seed, lag=lag, cycles=True) for seed, lag in enumerate(lags)]
    cases += [run("clones", 7, lag=0.5, cycles=False), run("clone", 0, lag=0.5, cycles=True)]
    assert rapid_evolution.antiphase(cases, "clones") == 3


def test_arms_are_compared_by_seed_without_those_that_lack_a_value_in_one_of_them():
    cases = [run("clones", seed, period=period) for seed, period in ((1, 300.0), (2, 320.0), (3, None))]
    cases += [run("clone", seed, period=100.0) for seed in (1, 2, 3)]
    mean, low, high = rapid_evolution.gap(cases, "period", "clones", "clone")
    half = 12.706 * 14.142 / 2**0.5  # Student's t with one degree of freedom; 200 and 220 deviate by 14.142
    assert (mean, low, high) == pytest.approx((210.0, 210 - half, 210 + half), abs=0.1)


def test_a_pause_undoes_half_of_a_change_in_log_weight_from_8_to_2_grams_with_4_at_its_end():
    weights = [0.0] * 31
    weights[fishing_for_size.BEFORE], weights[fishing_for_size.AFTER], weights[-1] = 8.0, 2.0, 4.0
    cases = [run("largest", seed, weight=" ".join(map(str, weights))) for seed in (1, 2)]
    with np.errstate(divide="ignore"):
        assert fishing_for_size.recovery(cases, "largest") == [0.5, 0.5, 0.5]


def test_ratios_of_catches_are_of_totals_and_paired_by_seed():
    cases = [run("smallest", 1, **{"yield": "1 2 3"}), run("largest", 1, **{"yield": "9 2 0.5"})]
    cases += [run("smallest", 2, **{"yield": "0 5 5"}), run("largest", 2, **{"yield": "0 4 1"})]
    first, second = (fishing_for_size.catch(cases, arm, 1, 3) for arm in ("smallest", "largest"))
    assert fishing_for_size.ratio(first, second)[0] == 2.0  # 5 to 2.5, and 10 to 5
