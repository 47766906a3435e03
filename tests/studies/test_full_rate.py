"""What the study of learning at full rate concludes from made-up cases, and that it puts policies back."""

import math

import numpy as np
import pytest

from ecs_eco.config import load
from studies import full_rate as study
from studies.common.predator_prey import SHIPPED


def _life(moves=(0.2, 0.06, 0.08), persisted=True, **more):
    return {
        "persisted": persisted,
        "lived": 6000.0 if persisted else 900.0,
        "cycled": False,
        "period": None,
        "extinct": None if persisted else "wolf",
        "series": {},
        "numbers": {
            s: {"mean": 9.0, "least": float(persisted), "most": 20.0} for s in ("grass", "deer", "wolf")
        },
        "moved": {s: list(moves) for s in study.LEARNERS},
        **more,
    }


def _after(catch):
    pairs = dict(zip(study.PAIRS, (1.5, 1.6, 0.4, 1.4), strict=True))
    return {
        "swaps": {pair: 300 + 1000 * ("first deer" in pair) for pair in study.PAIRS},
        "arena": {pair: {"caught": v + catch, "grazed": 0.8} for pair, v in pairs.items()},
        "answer": {"caught": 1.7, "grazed": 0.8},
    }


def _cases():
    out = []
    for n, case in enumerate(study.all_cases()):
        dies = case["arm"] in ("both", "deer")
        after = _after(n / 100) if case["arm"] == "both" and case["seed"] == 12201 else {}
        out.append({"case": case, "result": _life(persisted=not dies, **after)})
    return out


def _met(cases):
    return {
        line["registered"]: line["met"] for line in study.summarise(cases)["verdicts"] if "registered" in line
    }


def test_the_move_of_a_policy_leaves_out_the_first_window():
    assert study.pace(_life(), "deer") == pytest.approx(0.07)
    assert math.isnan(study.pace(_life(moves=(0.2,)), "deer"))
    assert math.isnan(study.pace({"moved": {}}, "deer"))


def test_a_run_counts_where_both_move_and_all_persist():
    lives = [_life(), _life(moves=(0.2, 0.04)), _life(persisted=False), _life(())]
    assert study.both_move(lives, 0.05) == 0.25


def test_the_verdicts_follow_from_the_cases():
    met = _met(_cases())
    assert met == dict.fromkeys(study.REGISTERED.hypotheses, True) | {"forgetting": False}
    others = _cases()
    for c in others:
        if c["case"]["arm"] in ("regime", "deer"):
            c["result"] |= {**_life(), "moved": {"deer": [0.2, 0.01], "wolf": [0.2, 0.2]}}
    met = _met(others)
    assert not met["regime"]
    assert not met["deer"]


def test_a_candidate_lies_within_the_ranges_and_is_a_world():
    ranges = study.REGISTERED.content["search"]["ranges"]
    drawn = study.candidate(12301)
    for key, (low, high) in ranges.items():
        for species in study.LEARNERS:
            assert low <= drawn[key.replace("both", species)] <= high
    assert drawn["species.deer.ppo.epochs"] == drawn["species.wolf.ppo.epochs"]
    assert drawn != study.candidate(12302)
    load("predator-prey", study.QUARTER | drawn)


def test_policies_are_put_back_and_only_wolves_learn_in_the_arena():
    first = study.first_of(SHIPPED)
    world = study.put(study.arena(1, True), first)
    got = study.counted(world, 70, 10)
    assert set(got) == {"caught", "grazed"}
    now = {s: study.state(world, s) for s in study.LEARNERS}
    assert all(np.array_equal(now["deer"][k], v) for k, v in first["deer"].items())
    assert not all(np.array_equal(now["wolf"][k], v) for k, v in first["wolf"].items())
