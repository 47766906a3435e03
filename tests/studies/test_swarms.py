"""Prey that swarm: the study's statistics on numbers counted by hand."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.testing import arrange
from studies import swarms


def run(arm, seed, **result):
    return {"case": {"arm": arm, "seed": seed}, "result": result}


def test_attraction_and_alignment_are_differences_between_weights_for_left_and_for_right():
    weights = np.zeros((1, 4, 4))  # inputs: left, right, forward, left; outputs: left, none, right, value
    weights[0, 0] = [3, 9, 1, 5]  # prey on the left: 2 more for left than for right
    weights[0, 1] = [-1, 9, 3, 2]  # prey on the right: 4 more for right
    weights[0, 3] = [0.5, 9, 2, 9]  # neighbors head to the left: 1.5 more for right
    flat = np.concatenate([weights.reshape(1, 16), np.full((1, 4), 7.0)], axis=1)
    assert [float(x[0]) for x in swarms.turning(flat)] == [(2 + 4) / 2, -1.5, 5 - 2]


def test_prey_on_a_square_lattice_are_twice_as_far_apart_as_prey_at_random():
    world = World.from_config(load(swarms.STUDY.config["world"]), seed=1, record=False)
    x, y = np.divmod(np.arange(400), 20)
    prey = arrange(world, "prey", x=3.0 * x + 1, y=3.0 * y + 1)
    near, ratio = swarms.aggregation(world, prey)
    assert (near, ratio) == pytest.approx((0.0, 2.0), abs=1e-5)  # 3 m away is not nearer than 3 m
    prey = arrange(world, "prey", x=59.5 + (x > 9), y=3.0 * (y // 2) + 1)  # across the edge, 4 at each place
    assert swarms.aggregation(world, prey)[1] == pytest.approx(0.0, abs=1e-5)


def test_growth_is_the_geometric_mean_ratio_of_the_last_to_the_first_looks():
    cases = [run("none", 1, near="2 2 2 2 9 8 8 8 8"), run("none", 2, near="4 4 4 4 9 4 4 4 4")]
    assert swarms.growth(cases, "none")[0] == 2.0  # 4 and 1
    cases += [run("drawn", 1, near="1 1 1 1 1 2 2 2 2"), run("drawn", 2, near="1 1 1 1 1 1 1 1 1")]
    assert swarms.ratio(cases, "none", "drawn") == [4.0, 4.0, 4.0]
    assert swarms.gap(cases, "near", "none", "drawn")[0] == (8 - 2 + 4 - 1) / 2
