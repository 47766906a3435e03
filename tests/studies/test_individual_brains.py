"""The conclusions that the study of individual brains draws from made-up cases."""

import pytest

from studies import individual_brains as study


def _run(persisted=True, variation=0.1, learnt=0.02, speed=120.0):
    return {
        "persisted": persisted,
        "lived": 20000.0 if persisted else 700.0,
        "extinct": None if persisted else "wolf",
        "numbers": {s: {"mean": 9.0} for s in ("grass", *study.LEARNERS)},
        "variation": dict.fromkeys(("grass", *study.LEARNERS), variation),
        "learnt": dict.fromkeys(study.LEARNERS, learnt),
        "ticks per second": speed,
    }


EXPECTED = {"individual": _run(), "not inherited": _run(persisted=False), "shared": _run(variation=0.5)}


def _met(changed=None, of="individual", n=16):
    """Verdicts by name, if the first `n` runs of an arm are as changed."""
    entries, left = [], n
    for case in study.STUDY.cases:
        wrong = changed is not None and case["arm"] == of and left > 0
        left -= wrong
        entries.append({"case": case, "result": changed if wrong else EXPECTED[case["arm"]]})
    return {line["registered"]: line["met"] for line in study.summarise(entries)["verdicts"]}


def test_all_hypotheses_hold_as_expected():
    assert _met() == dict.fromkeys(study.REGISTERED.hypotheses, True)


@pytest.mark.parametrize(
    ("changed", "of", "n", "hypothesis"),
    [
        (_run(persisted=False), "individual", 2, "persists"),
        (_run(), "not inherited", 2, "inherited"),
        (_run(variation=0.3), "individual", 16, "steadier"),
        (_run(learnt=0.004), "individual", 16, "learn"),
        (_run(speed=59.0), "individual", 1, "speed"),
    ],
)
def test_each_hypothesis_can_fail(changed, of, n, hypothesis):
    assert not _met(changed, of, n)[hypothesis]
    if hypothesis in ("persists", "inherited"):
        assert _met(changed, of, n - 1)[hypothesis]


def test_a_policy_that_does_not_change_is_at_distance_zero():
    import numpy as np

    from ecs_eco import World

    living = World.from_config(study.world("individual"), seed=3, policies="trained", learn=False).run(3)
    before = study.networks_of(living, "deer")
    assert len(before) == study.MOST
    assert np.allclose(study.changes(living, "deer", before), 0.0)
