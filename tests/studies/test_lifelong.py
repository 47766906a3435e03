"""The conclusions that the study of lifelong learning draws from made-up cases."""

import pytest

from ecs_eco.config import for_training
from studies import lifelong as study
from studies.common.predator_prey import frozen


def _run(persisted=True, moved=0.1, lag=0.3, p=0.01):
    return {
        "persisted": persisted,
        "extinct": None if persisted else "wolf",
        "moved": {s: [moved] * 20 for s in study.LEARNERS},
        "numbers": {s: {"mean": 9.0} for s in ("grass", *study.LEARNERS)},
        "cycles": {
            "period": 900.0,
            "period_of": list(study.LEARNERS),
            "p_ar1": dict.fromkeys(study.LEARNERS, p),
            "lags": {
                "deer→wolf": {"share": lag, "low": lag - 0.02, "high": lag + 0.02},
                "grass→deer": {"share": 0.4, "low": 0.38, "high": 0.42},
            },
        },
    }


def _met(results):
    cases = [c for c in study.STUDY.cases if c["arm"] == "learning"]
    entries = [{"case": c, "result": r} for c, r in zip(cases, results, strict=True)]
    return {line["registered"]: line["met"] for line in study.summarise(entries)["verdicts"]}


@pytest.mark.parametrize(
    ("wrong", "hypothesis", "most"),
    [
        (_run(persisted=False), "persists", 2),
        (_run(lag=0.38), "cycles", 6),
        (_run(p=0.06), "cycles", 6),
        (_run(moved=0.04), "moves", 4),
    ],
)
def test_a_hypothesis_fails_with_one_wrong_run_too_many(wrong, hypothesis, most):
    fine = [_run() for _ in range(40)]
    assert set(_met(fine)) == set(study.REGISTERED.hypotheses)
    assert all(_met(fine).values())
    assert _met([wrong] * most + fine[most:])[hypothesis]
    assert not _met([wrong] * (most + 1) + fine[most + 1 :])[hypothesis]


def test_the_median_lags_must_be_those_of_cycles():
    assert _met([_run(lag=0.35)] * 40)["deer→wolf"]
    late = _met([_run(lag=0.36)] * 40)
    assert late["cycles"]
    assert not late["deer→wolf"]


def test_a_policy_must_move_in_each_quarter():
    assert study.by_quarter([0.4] * 5 + [0.1] * 10 + [0.02] * 5) == pytest.approx([0.4, 0.1, 0.1, 0.02])
    settled = _run() | {"moved": {"deer": [0.4] * 15 + [0.02] * 5, "wolf": [0.1] * 20}}
    assert not study.moves(settled)
    assert not study.moves(_run() | {"moved": {"deer": [0.4] * 3, "wolf": [0.1] * 20}})


def test_both_arms_learned_before_the_run_as_the_frozen_worlds_of_other_studies_did():
    former = for_training(frozen()).resolved()
    for arm in study.REGISTERED.arms:
        mine = for_training(study.world(arm)).resolved()
        for species in study.LEARNERS:
            assert mine["species"][species]["ppo"] == former["species"][species]["ppo"]
            for key in ("diet", "metabolism", "sensors", "happiness"):
                assert mine["species"][species][key] == former["species"][species][key]
