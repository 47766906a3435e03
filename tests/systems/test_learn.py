"""The systems hand the learner what happened: credit order, deaths and births in mid-rollout."""

import numpy as np
import pytest

from ecs_eco import System
from ecs_eco.components import Experience, Metabolism, Nervous

POLICY = {
    "policy": {"kind": "shared", "hidden": [4]},
    "ppo": {"horizon": 4, "epochs": 1},
    "happiness": {"formula": "energy", "minimum": -1.0},
}
OPTIONS = {"policies": "untrained", "learn": True}


def _learner(world):
    return world.tables["deer"].species.nerves.learner


def test_an_update_comes_when_the_rollout_has_its_horizon_and_the_record_of_the_last_action_is_complete(
    meadow,
):
    world = meadow(options=OPTIONS, **POLICY)
    learner = _learner(world)
    weights = learner.brain.state()["policy.head.weight"]
    world.run(4)
    assert (learner.updates, learner.rollout.n, learner.rollout.ticks) == (0, 8, 4)
    assert (learner.brain.state()["policy.head.weight"] == weights).all()
    world.run(1)  # senses, feels, learns, then decides: the first of the next rollout
    assert (learner.updates, learner.rollout.n, learner.rollout.ticks) == (1, 2, 1)
    assert (learner.brain.state()["policy.head.weight"] != weights).any()
    report = world.tables["deer"].species.nerves.reports[-1]
    assert (report["tick"], report["n_transitions"]) == (4, 8)


def test_the_reward_of_an_action_is_what_is_felt_a_tick_later(meadow):
    world = meadow(options=OPTIONS, metabolism={"basal": 0.0}, **POLICY)
    table = world.tables["deer"]
    energies = [[0.5, 0.5], [0.625, 0.25], [0.625, 0.5]]
    for energy in energies:
        table[Metabolism].energy[table.by_uid()] = energy
        world.run(1)
    rollout = _learner(world).rollout
    uid = table.uid[rollout.steps["row"]]
    for i, u in enumerate(np.sort(table.uid[table.rows()])):
        reward = rollout.steps["reward"][uid == u]
        felt = np.array(energies)[:, i]
        assert reward[:2] == pytest.approx(np.diff(felt))
        assert reward[2] == 0  # not felt yet


def test_who_dies_and_is_born_into_its_row_in_mid_rollout(meadow):
    world = meadow(
        count=3,
        options=OPTIONS,
        metabolism={"basal": 0.0},
        locomotion={"cost": {"walk": 0.0, "run": 0.0}},
        **POLICY,
    )
    table, rollout = world.tables["deer"], _learner(world).rollout
    table[Metabolism].energy[table.rows()] = 0.5
    world.run(1)
    first = int(table.uid[0])
    world.kill(first, "drowned")
    world.spawn("deer")
    world.run(1)  # decides once more, dies, and its row is taken by a newborn
    assert table.uid[0] == world.next_uid - 1
    world.run(1)
    row0 = np.flatnonzero(rollout.steps["row"] == 0)
    assert rollout.ended[row0].tolist() == [False, True, False]
    # minimum −1 minus what it felt
    assert rollout.steps["reward"][row0].tolist() == pytest.approx([0.0, -1.5, 0.0])
    world.get(world.next_uid - 1, Metabolism).energy = 0.75
    world.run(1)
    assert rollout.steps["reward"][row0].tolist() == pytest.approx([0.0, -1.5, 0.25])
    assert rollout.ended.sum() == 1
    world.run(1)  # an update: nothing is missing
    assert _learner(world).updates == 1


def test_a_population_that_dies_out_learns_no_more_and_nothing_breaks(meadow):
    world = meadow(options=OPTIONS, **POLICY)
    world.run(2)
    for uid in world.tables["deer"].uid[world.tables["deer"].rows()].tolist():
        world.kill(uid)
    world.run(10)
    assert world.tables["deer"].n == 0
    assert _learner(world).updates == 0
    world.spawn("deer", n=2)
    world.run(10)
    assert _learner(world).updates >= 1
    assert np.isfinite(world.tables["deer"][Nervous].reward[:2]).all()


def test_a_species_that_does_not_learn_keeps_its_weights(meadow):
    world = meadow(options={"policies": "untrained", "learn": False}, **POLICY)
    brain = world.tables["deer"].species.nerves.brain
    before = brain.state()
    world.run(10)
    assert all((v == before[k]).all() for k, v in brain.state().items())
    assert _learner(world) is None


class Praise(System):
    """Each animal is rewarded with the last digit of its uid, in place of its happiness."""

    needs = (Nervous,)
    phase = "feel"

    def update(self, table, world):
        table[Nervous].reward[table.alive] = table.uid[table.alive] % 10


@pytest.mark.parametrize("kind", ["shared", "individual"])
def test_a_reward_that_a_system_writes_in_feel_is_what_the_learner_gets(meadow, kind):
    world = meadow(
        count=8,
        options=OPTIONS | {"systems": [Praise()]},
        metabolism={"basal": 0.0},
        locomotion={"cost": {"walk": 0.0, "run": 0.0}},
        **POLICY | {"policy": {"kind": kind, "hidden": [4]}, "ppo": {"horizon": 16, "epochs": 1}},
    )
    table = world.tables["deer"]
    table[Metabolism].energy[table.rows()] = 0.5
    world.run(2)
    rows = table.by_uid()[5:]  # individuals take turns at learning: these have not yet had theirs
    digit = table.uid[rows] % 10
    if kind == "individual":
        assert table[Experience].reward[rows][:, 0].tolist() == digit.tolist()
        return
    world.kill(int(table.uid[rows[0]]))
    world.run(1)  # praised again, then one dies
    steps = table.species.nerves.learner.rollout.steps
    rewards = [steps["reward"][steps["row"] == row].tolist() for row in rows]
    assert rewards == [[digit[0], digit[0], -1.0 - 0.5], [digit[1], digit[1], 0], [digit[2], digit[2], 0]]


def test_the_learning_rate_falls_to_zero_in_a_run_too(meadow):
    world = meadow(
        options=OPTIONS,
        metabolism={"basal": 0.0},
        locomotion={"cost": {"walk": 0.0, "run": 0.0}},
        **POLICY | {"ppo": {"horizon": 4, "epochs": 1, "anneal": 16, "learning_rate": 0.01}},
    )
    world.run(21)
    rates = [report["learning_rate"] for report in world.tables["deer"].species.nerves.reports]
    assert rates == pytest.approx([0.01, 0.0075, 0.005, 0.0025, 0.0])
