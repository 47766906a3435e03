"""How far a policy has moved: by hand, and of a world that learns and one that does not."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from studies.common.moved import Crowd, Policies, divergence, rates

FEW = {
    "species.grass.count": 60,
    "species.deer.count": 20,
    "species.wolf.count": 4,
    "space.size": [50.0, 50.0],
    "species.deer.ppo.horizon": 8,
    "species.wolf.ppo.horizon": 8,
}


def test_divergence_is_summed_over_groups_and_averaged_over_observations():
    before = np.log([[0.5, 0.5, 0.2, 0.8], [0.5, 0.5, 0.2, 0.8]])
    after = np.log([[0.25, 0.75, 0.2, 0.8], [0.5, 0.5, 0.4, 0.6]])
    first = 0.5 * np.log(2) + 0.5 * np.log(0.5 / 0.75)
    second = 0.2 * np.log(0.5) + 0.8 * np.log(0.8 / 0.6)
    assert divergence(before, after, (2, 2)) == pytest.approx((first + second) / 2)
    assert divergence(before, before + 3.0, (4,)) == pytest.approx(0, abs=1e-12)
    assert np.isnan(divergence(before[:0], after[:0], (2, 2)))


@pytest.mark.parametrize("learn", [False, True])
def test_a_policy_that_learns_moves_and_one_that_does_not_stays(learn):
    world = World.from_config(
        load("predator-prey", FEW), seed=1, policies="untrained", learn=learn, record=False
    )
    before = Policies(world)
    world.run(20)
    moved = before.moved()
    assert set(moved) == {"deer", "wolf"}
    assert (moved["deer"] > 1e-6) == learn
    assert rates({"deer": 0.5, "wolf": None}, 2000) == {"deer": 0.25, "wolf": None}


@pytest.mark.slow
@pytest.mark.parametrize("learn", [False, True])
def test_what_individuals_do_on_average_moves_where_they_learn(learn):
    alone = {"species.deer.policy.kind": "individual", "species.deer.policy.inherit": "learned"}
    world = World.from_config(load("predator-prey", FEW | alone), seed=1, learn=learn, record=False)
    before = Crowd(world, ["deer"], most=10)
    world.run(20)
    moved = before.moved()["deer"]
    assert moved > 1e-6 if learn else moved == pytest.approx(0, abs=1e-9)
