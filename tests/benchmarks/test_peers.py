"""The common task of the benchmark of peers is the same in ecs-eco and in the bare loop."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
import peers
import peers_grazing


def numbers(make, n, seed, ticks):
    tick, living = make(n, seed)
    out = []
    for _ in range(ticks):
        tick()
        out.append(living())
    return np.array(out)


def test_ecs_eco_and_the_bare_loop_have_as_many_grazers():
    ours, bare = (
        np.mean([numbers(make, 2000, seed, 60) for seed in (1, 2)], axis=0)
        for make in (peers_grazing.ecs_eco, peers_grazing.bare)
    )
    assert np.abs(bare / 2000 - 1).max() > 0.05  # births and deaths do matter by then
    assert abs(ours.mean() / bare.mean() - 1) < 0.05
    assert abs(ours[-10:].mean() / bare[-10:].mean() - 1) < 0.1


def test_a_row_holds_the_best_round_beside_the_floor_and_why_there_is_none():
    found = {
        ("bare loop", 10): [{"steps/s": 8e6, "after": 11}],
        ("Mesa", 10): [{"steps/s": 1e4, "after": 10}, {"steps/s": 2e4, "after": 12}],
        ("AgentPy", 10): [{"why": "No module named 'agentpy'"}],
    }
    _, mesa, agentpy = peers.rows_of(found)
    assert mesa["k organism-steps/s"] == 20
    assert mesa["bare loop's speed / this speed"] == 400
    assert mesa["live animals after 20 ticks / bare loop's"] == 1
    assert agentpy["note"] == "No module named 'agentpy'"
    assert agentpy["k organism-steps/s"] is None
