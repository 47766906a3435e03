"""How the study of 100,000 ticks tells a policy that settles, circles or drifts, and the conclusions it draws."""

import numpy as np
import pytest

from studies import never_settling as study

TIMES = np.arange(10)
LAGS = np.abs(TIMES[:, None] - TIMES)
DRIFT, BOUNDED, SETTLED = 0.3 * LAGS, 0.3 * np.minimum(LAGS, 2), 0.01 * (LAGS > 0)
EVEN = np.log(0.02) + 0.3 * (LAGS == 0)  # wolves catch more of the deer of their own time


def _run(distances, tests=EVEN):
    return {
        "persisted": True,
        "lived": 100_000,
        "distances": {s: np.asarray(distances, float).tolist() for s in study.LEARNERS},
        "tests": np.asarray(tests, float).tolist(),
    }


def _met(run):
    lines = study.summarise([{"case": case, "result": run} for case in study.STUDY.cases])["verdicts"]
    return {line["registered"]: line["met"] for line in lines}


def test_a_random_walk_is_seven_times_as_far_after_half_a_run_as_after_one_step():
    assert study.change(_run(DRIFT), "deer") == pytest.approx(0.3)
    assert np.exp(study.growth(_run(DRIFT), "deer")) == pytest.approx(7.0)
    assert np.exp(study.growth(_run(BOUNDED), "deer")) == pytest.approx(2.0)


def test_what_moves_within_bounds_meets_all_goals():
    assert _met(_run(BOUNDED)) == dict.fromkeys(study.REGISTERED.hypotheses, True)


@pytest.mark.parametrize(
    ("run", "wrong"),
    [
        (_run(DRIFT), {"deer-bounded", "wolf-bounded"}),
        (_run(SETTLED), {"deer-moves", "wolf-moves"}),
        (_run(BOUNDED, EVEN + 0.06 * TIMES[:, None]), {"wolf-trend"}),
        (_run(BOUNDED, EVEN - 0.06 * TIMES), {"deer-trend"}),
        (_run(BOUNDED, np.zeros((10, 10))), {"contemporary"}),
    ],
)
def test_each_hypothesis_can_fail(run, wrong):
    assert {name for name, met in _met(run).items() if not met} == wrong
