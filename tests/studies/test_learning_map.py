"""The conclusions that the map of learning rates draws from made-up cases."""

import pytest

from studies import learning_map as study


def _run(persisted):
    return {
        "persisted": persisted,
        "extinct": None if persisted else "wolf",
        "moved": {"deer": [0.1], "wolf": [0.2]},
        "numbers": {s: {"mean": 9.0} for s in ("deer", "wolf")},
        "cycles": {
            "period": 900.0,
            "period_of": ["deer", "wolf"],
            "p_ar1": {"deer": 0.01, "wolf": 0.2},
            "lags": {},
        },
    }


def _lines(alive):
    entries = [{"case": c, "result": _run(alive(c))} for c in study.STUDY.cases]
    return {line["registered"]: line for line in study.summarise(entries)["verdicts"]}


def test_each_hypothesis_follows_from_the_runs_it_names():
    lines = _lines(lambda case: True)
    assert [line["met"] for line in lines.values()] == [False, False, False, True]
    lines = _lines(lambda case: case["arm"] == "shipped" or case["deer"] == 0)  # 6 of 36 pairs on a quarter
    assert lines["ground"]["value"][0] == pytest.approx(1 - 6 / 36, abs=0.001)
    assert lines["fast deer"]["value"][0] == pytest.approx((1 + 1 / 3) / 2 - 1 / 2 + (1 - 1) / 2, abs=0.001)
    assert lines["fast wolves"]["value"] == pytest.approx([0, 0, 0])
    assert [line["met"] for line in lines.values()] == [True, True, False, True]
    lines = _lines(lambda case: case["wolf"] <= 1e-3 and case["training"] != 16004)
    assert lines["fast wolves"]["value"][0] == pytest.approx(0.75)
    assert not lines["at the shipped rates"]["met"]


def test_the_cases_are_every_pair_on_two_grounds_and_the_shipped_rates_on_four():
    cases = study.STUDY.cases
    assert len(cases) == 4 * (2 * 36 + 2)
    assert {c["arm"] for c in cases if (c["deer"], c["wolf"]) != study.SHIPPED} == set(study.MAPS)
    density = {
        name: [w.species[s].count / (w.space.size[0] * w.space.size[1]) for s in ("grass", "deer", "wolf")]
        for name in study.REGISTERED.arms
        for w in [study.world({"arm": name, "deer": 4e-3, "wolf": 0.0})]
    }
    for values in density.values():
        assert values == pytest.approx(density["shipped"], rel=0.01)


def test_a_rate_of_zero_freezes_a_policy():
    world = study.world({"arm": "quarter", "deer": 0.0, "wolf": 8e-3})
    assert not world.species["deer"].policy.learn
    assert world.species["wolf"].ppo["learning_rate"] == 8e-3
