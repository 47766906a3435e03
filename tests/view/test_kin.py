"""Who is whose child."""

import numpy as np

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.view.kin import Kin


def family():
    world = World([10, 10], name="family")
    world.add_table("deer", Position)
    world.add_table("wolf", Position)
    world.spawn("deer", n=2)
    world.flush()
    return world


def test_parents_children_and_generations_are_noted():
    world = family()
    kin = Kin(world)
    world.table("deer").request(np.array([1, 1], np.uint64), {}, np.array([2, 0], np.uint64))
    world.flush()
    world.table("deer").request(np.array([3], np.uint64), {})
    world.flush()
    assert kin.parents(3) == [1, 2]
    assert kin.parents(4) == [1]
    assert kin.children(1) == [3, 4]
    assert kin.children(2) == [3]
    assert [kin.generation(uid) for uid in (1, 3, 5)] == [0, 1, 2]
    assert kin.species(5) == "deer"
    assert kin.species(6) is None
    assert kin.parents(99) == []


def test_deaths_are_noted_with_cause_and_killer():
    world = family()
    world.spawn("wolf")
    world.flush()
    kin = Kin(world)
    world.kill(1, "eaten by wolf", killer=3)
    world.kill(2, "starved")
    world.step()
    assert kin.died(1) == {"tick": 0, "cause": "eaten by wolf", "killer": 3}
    assert kin.died(2) == {"tick": 0, "cause": "starved", "killer": None}
    assert kin.died(3) is None
    assert kin.born(1) == 0


def test_the_oldest_lives_are_forgotten_before_memory_runs_out():
    world = family()
    kin = Kin(world, most=1000)
    parent = 1
    for _ in range(50):
        first = world.next_uid
        world.table("deer").request(np.full(100, parent, np.uint64), {})
        world.flush()
        parent = first
    assert kin.n <= 1000
    assert all(column.size <= 4096 for column in kin._columns.values())
    last = world.next_uid - 1
    assert kin.parents(last) == [last - 199]  # the first of the hundred before
    assert kin.species(1) is None


def test_who_listens_no_longer_notes_nothing():
    world = family()
    kin = Kin(world)
    kin.forget()
    world.spawn("deer")
    world.flush()
    assert kin.species(3) is None
