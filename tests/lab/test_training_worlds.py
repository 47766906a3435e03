import numpy as np
import pytest

from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.lab.pretraining import TrainingWorlds, drawn, pretrain

VARY = {"species.ram.count": [4, 30], "species.moss.reproduction.seed_rain": [0.1, 0.4]}


def plan(menagerie, **training):
    return load(menagerie(training={"average": 0.5, "worlds": 3, "vary": VARY} | training))


def test_each_world_draws_from_a_part_of_the_range_of_its_own():
    values = drawn({"a": [1.0, 16.0], "b": [0.0, 4.0], "c": [1, 3]}, 4, 77)  # c: whole numbers
    parts = sorted(int(np.log2(world["a"])) for world in values)
    assert parts == [0, 1, 2, 3]  # equal factors: 1 to 2, 2 to 4, 4 to 8, 8 to 16
    # zero has no logarithm: equal differences
    assert sorted(int(world["b"]) for world in values) == [0, 1, 2, 3]
    assert all(isinstance(world["c"], int) and world["c"] in (1, 2, 3) for world in values)
    assert [w["a"] for w in drawn({"a": [1.0, 16.0]}, 4, 78)] != [
        w["a"] for w in drawn({"a": [1.0, 16.0]}, 4, 79)
    ]


@pytest.mark.slow
def test_several_worlds_with_numbers_of_their_own_train_one_policy(menagerie):
    training_worlds = TrainingWorlds(plan(menagerie), seed=3)
    numbers = [world.tables["ram"].n for world in training_worlds.worlds]
    assert len(set(numbers)) == 3
    brains = {id(world.tables["ram"].species.nerves.brain) for world in training_worlds.worlds}
    assert len(brains) == 1
    training_worlds.run(80)
    reports = training_worlds.worlds[2].tables["ram"].species.nerves.reports
    assert [(r["tick"], r["n_transitions"]) for r in reports] == [
        (t, 12 * sum(numbers)) for t in (12, 24, 36, 48, 60, 72)
    ]
    assert [world.tick for world in training_worlds.worlds] == [80, 80, 80]


@pytest.mark.slow
def test_the_same_seed_trains_the_same_policies_in_several_worlds(menagerie):
    one, two = (pretrain(plan(menagerie, renew=41, pool=0.5), seed=2, ticks=100) for _ in range(2))
    other = pretrain(plan(menagerie, renew=41, pool=0.5), seed=3, ticks=100)
    for name, weights in one["policies"]["ram"].items():
        assert np.array_equal(weights, two["policies"]["ram"][name])
    assert any(
        (weights != other["policies"]["ram"][name]).any() for name, weights in one["policies"]["ram"].items()
    )
    assert one["curves"] == two["curves"]
    assert one["curves"]["ram"]["tick"][-1] == 100
    assert all(np.isfinite(v).all() for v in one["curves"]["ram"].values())


@pytest.mark.slow
def test_worlds_begin_anew_and_an_earlier_self_does_not_learn(menagerie):
    training_worlds = TrainingWorlds(plan(menagerie, renew=41, pool=1.0), seed=3)
    training_worlds.run(42)
    first = training_worlds.brains()["ram"].state()
    training_worlds.run(30)
    assert training_worlds.tick == 72
    assert [world.tick for world in training_worlds.worlds] == [30, 30, 30]
    nerves = [world.tables["ram"].species.nerves for world in training_worlds.worlds]
    assert [n.learning for n in nerves] == [True, False, False]
    training_worlds.run(12)  # one update of the first world alone
    assert any((training_worlds.brains()["ram"].state()[k] != v).any() for k, v in first.items())
    for n in nerves[1:]:
        assert all(np.array_equal(n.brain.state()[k], v) for k, v in first.items())


def test_a_range_that_is_none_and_a_value_out_of_bounds_are_refused(menagerie):
    with pytest.raises(ConfigError, match=r"training\.vary.*\n.*low < high"):
        plan(menagerie, vary={"species.ram.count": [30, 4]})
    with pytest.raises(ConfigError, match=r"cuont.*\n?.*count"):
        plan(menagerie, vary={"species.ram.cuont": [3, 4]})
    with pytest.raises(ConfigError, match="at least 0"):
        plan(menagerie, vary={"species.moss.reproduction.seed_rain": [-1.0, 0.4]})


def test_one_world_trains_as_it_always_did(menagerie):
    config = load(menagerie(training={"average": 0.5}))
    training_worlds = TrainingWorlds(config, seed=5)
    assert training_worlds.learners == {}
    assert training_worlds.worlds[0].seed == 5
