"""Choices from outside, as arrays: the same world as with the same choices from within."""

import gc
import weakref

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Metabolism, Nervous
from ecs_eco.engine.errors import ConfigError
from ecs_eco.engine.random import DECIDE, draw_many
from ecs_eco.learning import choose

POLICY = {"policy": {"kind": "shared", "hidden": [8]}, "count": 12}


def as_within(world, door, seen):
    """The choices that the species' own network would make."""
    nerves = world.tables[door.species].species.nerves
    logits, _ = nerves.brain.forward(seen.x)
    shape = len(seen.uid), len(nerves.offsets) - 1
    chance = np.stack([draw_many(world.key, seen.uid, DECIDE + (g << 8)) for g in range(shape[1])], 1)
    choice, log_probability = np.zeros(shape, np.int16), np.zeros(shape[0], np.float32)
    choose(logits, nerves.offsets, chance.astype(np.float32), choice, log_probability)
    return choice


@pytest.fixture
def alike():
    """Two worlds with births and deaths, alike."""
    return [World.from_config("predator-prey", seed=5, learn=False) for _ in range(2)]


def test_the_same_choices_from_outside_make_the_same_world(alike):
    within, outside = alike
    door = outside.external("deer")
    dead = 0
    for _ in range(25):
        seen = door.observe()
        dead += len(seen.dead)
        door.act(as_within(outside, door, seen))
    assert dead > 20
    assert within.run(25).digest() == outside.digest()
    assert within.series().equals(outside.series())


def test_it_goes_on_from_a_checkpoint_as_without(alike, tmp_path):
    world = alike[0]
    door = world.external("deer")
    for tick in range(12):
        if tick == 6:
            path = world.save(tmp_path / "between")
        seen = door.observe()
        door.act(as_within(world, door, seen))
    restored = World.restore(path)
    door = restored.external("deer")
    for _ in range(6):
        seen = door.observe()
        door.act(as_within(restored, door, seen))
    assert restored.digest() == world.digest()


def test_between_observe_and_act_a_world_is_neither_saved_nor_run(alike, tmp_path):
    world = alike[0]
    door = world.external("deer")
    first = door.observe()
    assert door.observe().uid.tolist() == first.uid.tolist()
    for act in (lambda: world.save(tmp_path / "x"), lambda: world.run(1), door.close):
        with pytest.raises(RuntimeError, match="in progress"):
            act()


def test_rewards_are_changes_of_happiness_and_the_dead_have_a_last_one(alike):
    world = alike[0]
    door, before = world.external("deer"), {}
    table = world.tables["deer"]
    for _ in range(12):
        seen = door.observe()
        now = dict(zip(seen.uid.tolist(), table[Nervous].happiness[table.species.nerves.rows], strict=True))
        for uid, reward in zip(seen.uid.tolist(), seen.reward, strict=True):
            assert reward == pytest.approx(now[uid] - before[uid] if uid in before else 0.0, abs=1e-6)
        for uid, reward in zip(seen.dead.tolist(), seen.dead_reward, strict=True):
            assert reward == pytest.approx(table.species.nerves.minimum - before[uid], abs=1e-6)
        assert set(before) - set(now) == set(seen.dead.tolist())
        assert len(seen.dead_cause) == len(seen.dead) == len(seen.dead_x)
        before = now
        door.act(as_within(world, door, seen))


def test_the_dead_show_what_they_sensed_last_and_why_they_died(meadow):
    world = meadow(**POLICY)
    door = world.external("deer")
    seen = door.observe()
    one, sensed = int(seen.uid[3]), seen.x[3].copy()
    world.get(one, Metabolism).energy = -1.0
    door.act(np.zeros((12, 2), int))
    seen = door.observe()
    assert seen.dead.tolist() == [one]
    assert seen.dead_x.tolist() == [sensed.tolist()]
    assert one not in seen.uid
    door.act(np.zeros((11, 2), int))
    assert not len(door.observe().dead)


def test_rows_may_come_in_any_order_with_their_uids(meadow):
    worlds = [meadow(**POLICY) for _ in range(2)]
    doors = [world.external("deer") for world in worlds]
    chosen = np.random.default_rng(1).integers(0, 3, (12, 2))
    order = np.random.default_rng(2).permutation(12)
    uid = doors[0].observe().uid
    doors[0].act(chosen)
    doors[1].observe()
    doors[1].act(chosen[order], uid[order])
    assert worlds[0].digest() == worlds[1].digest()


@pytest.mark.parametrize(
    ("uids", "says"),
    [
        (lambda uid: uid[:-1], r"no action \(1 in all\)"),
        (lambda uid: np.append(uid, 999_999), "999999.*\n.*dead, or of another species"),
        (lambda uid: np.append(uid, uid[0]), "given twice"),
    ],
)
def test_missing_dead_and_repeated_organisms_are_refused_and_nothing_changes(meadow, uids, says):
    world = meadow(**POLICY)
    door = world.external("deer")
    uid = door.observe().uid
    who = uids(uid)
    with pytest.raises(ConfigError, match=says):
        door.act(np.zeros((len(who), 2), int), who)
    door.act(np.zeros((12, 2), int), uid)  # the tick goes on once it is right
    assert world.tick == 1


@pytest.mark.parametrize(
    ("chosen", "says"),
    [
        (np.zeros((11, 2)), r"a row for each of the 12 deer"),
        (np.full((12, 2), np.nan), "not a number"),
        (np.full((12, 2), 7), "no such option"),
    ],
)
def test_impossible_actions_are_refused(meadow, chosen, says):
    door = meadow(**POLICY).external("deer")
    door.observe()
    with pytest.raises(ConfigError, match=says):
        door.act(chosen)


def test_of_a_partial_door_the_others_decide_by_themselves(meadow):
    worlds = [meadow(options={"policies": "untrained"}, **POLICY) for _ in range(2)]
    door = worlds[1].external("deer", partial=True)
    uid = door.observe().uid
    door.act(np.zeros((0, 2), int), uid[:0])
    assert worlds[0].run(1).digest() == worlds[1].digest()
    door.observe()
    door.act([[2, 0]], [uid[4]])
    table, rows = worlds[1].tables["deer"], worlds[1].tables["deer"].by_uid()
    nerves = table.species.nerves
    assert np.isnan(nerves.thoughts.logits).all(axis=1).sum() == 1
    place = int(np.flatnonzero(table.uid[rows] == uid[4])[0])
    assert table[Nervous].decision[rows[place], :6].tolist() == [0, 0, 1, 1, 0, 0]


def test_a_tick_with_two_doors_goes_on_when_both_have_acted(alike):
    world = alike[0]
    deer, wolf = world.external("deer"), world.external("wolf")
    deer.act(as_within(world, deer, deer.observe()))
    assert world.tick == 0
    wolf.act(as_within(world, wolf, wolf.observe()))
    assert world.tick == 1


def test_a_closed_door_gives_the_species_back(alike):
    door = alike[0].external("deer")
    with pytest.raises(ConfigError, match="it is already controlled"):
        alike[0].external("deer")
    door.close()
    with pytest.raises(RuntimeError, match="closed"):
        door.observe()
    assert alike[0].run(3).digest() == alike[1].run(3).digest()


def test_species_that_nobody_can_decide_for_are_refused(alike, meadow):
    with pytest.raises(ConfigError, match="nothing to choose"):
        alike[0].external("grass")
    with pytest.raises(KeyError, match="deer"):
        alike[0].external("dear")
    learner = meadow(options={"learn": True}, **POLICY)
    with pytest.raises(ConfigError, match="is learning from its own choices"):
        learner.external("deer")
    with pytest.raises(RuntimeError, match="call `observe` before `act`"):
        alike[0].external("deer").act(np.zeros((1, 2)))


def test_a_world_whose_door_is_dropped_is_freed(meadow):
    world = meadow(**POLICY)
    door = world.external("deer")
    door.observe()
    door.act(np.zeros((12, 2), int))
    gone = weakref.ref(world)
    del world, door
    gc.collect()
    assert gone() is None
