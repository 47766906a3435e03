"""What the study of the sea concludes from made-up cases: nobody left, one training seed,
an escape that is none."""

import numpy as np
import pytest

from studies import diel_migration as study

LIFE = {"copepods": 100, "mean number": 100.0, "days survived": 21.0}


def life(arm, training, seed, along=0.4):
    cycle = {
        "amplitude": abs(along),
        "vector": [along, 0.0],
        "lag [days]": 0.0,
        "p": 0.001,
        "r": 0.8,
        "mean depth": 15.0,
    }
    return {
        "case": {"arm": arm, "training": training, "seed": seed},
        "result": LIFE | {"cycle": None if along is None else cycle},
    }


def approach(arm, training, way, gain=2.5, seed=1):
    result = {
        "n": 10,
        "gain": gain,
        "way": way,
        "latency": 0 if gain >= 2 else None,
        "latency [s]": 0.0 if gain >= 2 else None,
    }
    return {"case": {"arm": arm, "training": training, "seed": seed}, "result": result}


def met(cases, words):
    (verdicts,) = [v for v in study.summarise(cases)["verdicts"] if words in v["statement"]]
    return verdicts["met"]


def test_an_interval_of_training_seeds_by_hand_and_of_one_of_them():
    assert study.interval([1.0, 2.0, 3.0]) == pytest.approx(
        [2, 2 - 4.303 / 3**0.5, 2 + 4.303 / 3**0.5], abs=1e-3
    )
    mean, low, high = study.interval([2.0])
    assert mean == 2
    assert np.isnan([low, high]).all()
    gap, p = study.contrast([1.0], [0.0, 0.1])
    assert gap[0] == 0.95
    assert np.isnan([*gap[1:], p]).all()


def test_one_training_seed_of_survivors_meets_nothing():
    dead = [life("inverted light", t, 1) | {"result": LIFE | {"cycle": None}} for t in (2, 3, 4)]
    shipped = [life("shipped", t, 1) for t in (1, 2, 3, 4)]
    assert met(
        [*shipped, *(life("inverted light", t, 1, -0.4 - t / 100) for t in (1, 2, 3, 4))], "inverted light"
    )
    assert not met([*shipped, life("inverted light", 1, 1, -0.4), *dead], "inverted light")
    assert not met([*shipped, *dead], "`inverted light`: runs with a measurable outcome")


def test_a_run_without_a_cycle_is_no_cycle():
    cases = [life("shipped", t, s) for t in (1, 2, 3, 4) for s in (1, 2)]
    assert met(cases, "largest p-value, by rotating whole days")
    cases[3]["result"]["cycle"] = None
    assert not met(cases, "largest p-value, by rotating whole days")
    assert not met(cases, "deeper by day")


def test_a_way_that_those_have_too_who_sense_nothing_is_no_escape():
    rng = np.random.default_rng(1)
    blind = [approach(study.SENSELESS, t, [0.15, 0.02], 1.0) for t in range(8)]
    drifts = [
        approach(study.FLEEING[0], t, [0.15 + d, 0.02 + e])
        for t, (d, e) in enumerate(rng.normal(0, 0.01, (8, 2)))
    ]
    flees = [approach(study.FLEEING[0], t, [0.6, 0.02 + e]) for t, e in enumerate(rng.normal(0, 0.05, 8))]
    assert not met([*blind, *drifts], "component away from the krill")
    assert met([*blind, *flees], "component away from the krill")
