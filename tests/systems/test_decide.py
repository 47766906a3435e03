import numpy as np
import pytest

from ecs_eco import System
from ecs_eco.components import Metabolism, Nervous, Policy
from ecs_eco.engine.random import DECIDE, draw_many
from ecs_eco.learning import choose
from ecs_eco.systems import Decide, Sense
from ecs_eco.testing import act, arrange

POLICY = {"policy": {"kind": "shared", "hidden": [8]}}


def _decision(world):
    act(world, Sense)
    act(world, Decide)
    table = world.tables["deer"]
    return table[Nervous].decision[table.by_uid()]


def test_without_policy_and_reflex_only_what_is_automatic_is_done(meadow):
    assert _decision(meadow()).tolist() == [[0, 0, 0, 0, 0, 0, 1]] * 2
    assert _decision(meadow(always_on=[])).tolist() == [[0] * 7] * 2


@pytest.mark.definition("3 reflex", "5 reflex")
def test_a_reflex_of_the_sensors_decides(meadow):
    links = [
        {"sensor": "energy", "action": "run", "weight": 1, "above": 0.5},
        {"sensor": "energy", "action": "eat", "weight": -1, "above": 0.5},
    ]
    world = meadow(reflex={"connections": links})
    arrange(world, "deer", energy=[0.4, 0.6])
    assert _decision(world).tolist() == [[0, 0, 0, 0, 0, 0, 1], [0, 0, 1, 0, 0, 0, 0]]


@pytest.mark.definition("3 policy", "3 actions", "5 choice", "5 decision")
def test_the_policy_takes_one_of_each_group_and_the_reflex_is_added(meadow):
    blocked = {"connections": [{"sensor": "energy", "action": "walk", "weight": -1, "above": -1.0}]}
    world = meadow(count=300, reflex=blocked, options={"policies": "random"}, **POLICY)
    decision = _decision(world)
    assert (decision[:, 1] == 0).all()
    assert 50 < (decision[:, :3].sum(axis=1) == 0).sum() < 150  # who would have walked does nothing: a third
    assert (decision[:, 3:6].sum(axis=1) == 1).all()
    assert (decision[:, 6] == 1).all()
    assert (decision[:, 3:6].sum(axis=0) > 60).all()


def test_choices_follow_from_logits_uid_and_tick_alone(meadow):
    world = meadow(count=50, options={"policies": "untrained"}, **POLICY)
    decision = _decision(world)
    table, nerves = world.tables["deer"], world.tables["deer"].species.nerves
    logits, _ = nerves.brain.forward(nerves.x)
    uid = table.uid[nerves.rows]
    chance = np.stack([draw_many(world.key, uid, DECIDE + (g << 8)) for g in range(2)], 1)
    choice, log_probability = np.zeros((50, 2), np.int16), np.zeros(50, np.float32)
    choose(logits, nerves.offsets, chance, choice, log_probability)
    z = np.zeros((50, 7), int)
    z[np.arange(50), choice[:, 0]] = 1
    z[np.arange(50), 3 + choice[:, 1]] = 1
    z[:, 6] = 1
    assert (decision == z[np.argsort(uid)]).all()
    world.tick += 1
    assert (_decision(world) != decision).any()


@pytest.mark.parametrize("learn", [True, False])
def test_a_learner_gets_what_was_sensed_and_chosen(meadow, learn):
    world = meadow(count=5, options={"policies": "untrained", "learn": learn}, **POLICY)
    nerves = world.tables["deer"].species.nerves
    _decision(world)
    assert (nerves.learner is not None) == learn
    if learn:
        rollout = nerves.learner.rollout
        assert (rollout.n, rollout.ticks) == (5, 1)
        assert (rollout.observations == nerves.x).all()
        assert rollout.steps["row"].tolist() == nerves.rows.tolist()
        assert (rollout.steps["log_probability"] < 0).all()


def test_a_policy_that_is_no_number_stops_with_species_tick_and_organism(meadow):
    for kind, word in (("shared", "weights are not"), ("individual", "weights are not")):
        world = meadow(policy={"kind": kind, "hidden": [4]}, ppo={}).run(3)
        deer = world.tables["deer"]
        if kind == "shared":
            deer.species.nerves.brain.weights[:] = np.nan
        else:
            deer[Policy].weights[deer.rows()] = np.nan
        uid = int(deer.uid[deer.species.nerves.rows[0]])
        with pytest.raises(
            FloatingPointError,
            match=f"deer, tick 3: the policy of organism [0-9]+ gives.*2 of 2 organisms are affected.*{word}",
        ) as error:
            world.run(1)
        assert str(uid) in str(error.value) or len(deer) == 2


def test_a_sense_that_is_no_number_is_named(meadow):
    world = meadow(policy={"kind": "shared", "hidden": [4]}, ppo={})
    deer = world.tables["deer"]

    class Spoil(System):  # within a tick: what is written between ticks is refused by the gate
        phase = "environment"

        def process(self, *_):
            deer[Metabolism].energy[int(deer.rows()[1])] = np.nan

    world.add_system(Spoil())
    with pytest.raises(FloatingPointError, match="its observations are energy = nan"):
        world.run(1)
