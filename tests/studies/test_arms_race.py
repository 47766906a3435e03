"""What the study of the arms race concludes from made-up cases."""

import numpy as np
import pytest

from studies import arms_race as study

TIMES = 4


def table(hunters=0.0, prey=0.0, own=0.0):
    """K of so many times: gains with the time of each, and on the diagonal."""
    i, j = np.mgrid[:TIMES, :TIMES]
    return (-4 + hunters * i + prey * j + own * (i == j)).tolist()


def life(arm, training, tests=None, pace=-0.1, sight=1.0, persisted=True):
    of = study.REGISTERED.arms[arm]
    first = {s: {"pace": [1.0, 0.1], "sight": [5.0, 1.0]} if of.get("genes") else {} for s in study.SIGHT}
    last = {
        s: {"pace": [1 + pace, 0.1], "sight": [5 + sight, 1.0]} if of.get("genes") else {}
        for s in study.SIGHT
    }
    result = {
        "persisted": persisted,
        "lived": 6000,
        "genes": [first, last],
        "tests": tests if of.get("tests") and persisted else None,
        "moved": {"deer": 0.3, "wolf": 0.6} if of.get("learn") else None,
    }
    return {"case": {"arm": arm, "training": training, "seed": 1}, "result": result}


def test_slopes_and_the_diagonal_by_hand():
    assert study.slope(table(hunters=0.3), "hunters", 3000) == pytest.approx(0.3)
    assert study.slope(table(hunters=0.3), "prey", 3000) == pytest.approx(0.0)
    assert study.slope(table(prey=-0.2), "prey", 6000) == pytest.approx(-0.1)
    assert study.contemporary(table(hunters=0.3, prey=-0.2)) == pytest.approx(0.0)
    assert study.contemporary(table(own=1.0)) == pytest.approx(0.75)


@pytest.mark.parametrize(("gain", "met"), [(0.3, True), (-0.3, False)])
def test_a_race_is_found_where_there_is_one(gain, met):
    rng = np.random.default_rng(1)
    cases = []
    for t in range(5):
        noise = rng.normal(0, 0.01)
        tests = table(gain + noise, -gain + noise, gain + noise)
        cases += [
            life(
                arm,
                t,
                tests,
                *(
                    (0.0, noise)
                    if arm == "drift"
                    else (0.3 * gain + noise, gain)
                    if arm != "no hunters"
                    else (-0.4, 0.0)
                ),
            )
            for arm in study.REGISTERED.arms
        ]
    lines = {
        line["registered"]: line["met"] for line in study.summarise(cases)["verdicts"] if "registered" in line
    }
    assert set(lines) == set(study.REGISTERED.hypotheses)
    assert lines["persists"]
    assert [
        lines[name] for name in ("both-hunters", "both-prey", "both-contemporary", "deer-pace", "deer-sight")
    ] == [met] * 5


def test_worlds_that_died_out_have_no_tests_and_meet_nothing():
    cases = [life(arm, t, persisted=False) for arm in study.REGISTERED.arms for t in range(5)]
    lines = [line for line in study.summarise(cases)["verdicts"] if "registered" in line]
    assert not any(line["met"] for line in lines)


def test_a_world_of_mean_animals_has_their_values():
    config = study.STUDY.config
    values = {"deer": {"pace": 0.9, "sight": 7.0}, "wolf": {"pace": 1.1, "sight": 5.0}}
    one, own = (study.world(config, {}, v) for v in (values, None))
    deer, wolf = one.species["deer"], one.species["wolf"]
    assert deer.sensors[study.SIGHT["deer"][1]].range == 7.0
    assert wolf.sensors[study.SIGHT["wolf"][1]].range == 5.0
    assert wolf.locomotion.speed["run"] == pytest.approx(1.1 * own.species["wolf"].locomotion.speed["run"])
    assert deer.locomotion.cost["run"] == pytest.approx(0.81 * own.species["deer"].locomotion.cost["run"])
