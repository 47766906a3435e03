"""What the study of deer that flee concludes from made-up cases, and that approaches are what they say."""

import numpy as np
import pytest

from studies import deer_that_flee as study
from studies.common.hunts import chase, run_away, walk_away
from studies.common.pursuit import COLUMNS, EDGES, share

WORLDS = {"deer": (7, 8, 9), "wolf": (1, 2, 3)}


def seen(who, forward, left, near):
    x = np.zeros((1, 14), np.float32)
    x[0, list(WORLDS[who])] = forward, left, near
    return x


def counts(near, far):
    out = np.zeros((len(EDGES) - 1, len(COLUMNS)))
    out[:, 0] = 10
    out[:3, 1], out[8:, 1] = 10 * near, 10 * far
    out[:3, 2] = -0.5 * out[:3, 1]
    return out.tolist()


def life(arm, training, near, far=0.1, swing=0.2, persisted=True):
    pursuit = {"deer": counts(near, far), "wolf": counts(near, far)}
    result = {
        "persisted": persisted,
        "cycled": persisted,
        "period": 1024.0,
        "extinct": None,
        "lived": 8000,
        "swing": {"deer": swing, "wolf": swing},
        "pursuit": pursuit,
    }
    return {"case": {"arm": arm, "training": training, "seed": 1}, "result": result}


def approaches(seed, walk, run):
    place = {"walk": {"survival": 0.1, "happiness": walk}, "run": {"survival": 0.9, "happiness": run}}
    grid = [{"cost": 0.01, "sight": 3.0, "speed": 1.3} | place]
    worlds = {"shipped": place | {"run": place["walk"]}, "fleeing": place}
    return {"case": {"arm": "approaches", "seed": seed}, "result": {"grid": grid, "worlds": worlds}}


def test_deer_turn_from_a_wolf_and_wolves_to_a_deer():
    uid = np.ones(1, np.uint64)
    assert run_away(seen("deer", 0.0, 1.0, 0.5), uid).tolist() == [[2, 2]]  # it is at the left: turn right
    assert walk_away(seen("deer", -1.0, 0.0, 0.5), uid).tolist() == [[1, 1]]  # behind: straight on
    assert walk_away(seen("deer", 0.0, 0.0, 0.0), uid).tolist() == [[0, 1]]
    assert chase(seen("wolf", 0.0, 1.0, 0.5), uid).tolist() == [[2, 0]]
    assert chase(seen("wolf", 0.0, 0.0, 0.0), uid).tolist() == [[1, 1]]


def test_shares_are_those_of_the_bins_within():
    table = counts(0.4, 0.1)
    assert share(table, "run", 0, 3) == pytest.approx(0.4)
    assert share(table, "run", 8, 12) == pytest.approx(0.1)
    assert share(table, "toward, running", 0, 3) == pytest.approx(-0.5)
    assert np.isnan(share(counts(0.0, 0.1), "toward, running", 0, 3))


@pytest.mark.parametrize(("near", "swing", "met"), [(0.5, 0.1, True), (0.12, 0.4, False)])
def test_goals_are_met_and_missed(near, swing, met):
    cases = [approaches(s, -0.9, 0.1 + s / 100) for s in range(3)]
    rng = np.random.default_rng(1)
    for t in range(5):
        noise = rng.normal(0, 0.01)
        cases += [
            life("shipped", t, 0.02, swing=0.2),
            life("walkers", t, 0.02, swing=0.3 + noise),
            life("fleeing", t, near + noise, swing=swing + noise),
        ]
    lines = {
        line["registered"]: line["met"] for line in study.summarise(cases)["verdicts"] if "registered" in line
    }
    assert set(lines) == set(study.REGISTERED.hypotheses)
    assert lines["pays"]
    assert not lines["too late"]
    assert [lines["learnt"], lines["cue"], lines["flight-swing"]] == [met] * 3
    assert not lines["period"]


def test_arms_without_runs_that_persist_meet_nothing():
    cases = [approaches(s, -0.9, 0.1 + s / 100) for s in range(3)]
    cases += [life(arm, t, 0.3, persisted=False) for arm in study.REGISTERED.arms for t in range(5)]
    lines = {
        line["registered"]: line["met"] for line in study.summarise(cases)["verdicts"] if "registered" in line
    }
    assert not any(lines[name] for name in ("persists", "period", "swing-deer", "flight-swing"))
