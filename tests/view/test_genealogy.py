"""Who is whose child."""

import numpy as np

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.view.genealogy import Genealogy
from ecs_eco.view.journal import Journal


def family():
    world = World([10, 10], name="family")
    world.add_table("deer", Position)
    world.add_table("wolf", Position)
    world.spawn("deer", n=2)
    world.flush()
    return world


def test_parents_children_and_generations_are_noted():
    world = family()
    pedigree = Genealogy(Journal(world))
    world.table("deer").request(np.array([1, 1], np.uint64), {}, np.array([2, 0], np.uint64))
    world.flush()
    world.table("deer").request(np.array([3], np.uint64), {})
    world.flush()
    assert pedigree.parents(3) == [1, 2]
    assert pedigree.parents(4) == [1]
    assert pedigree.children(1) == [3, 4]
    assert pedigree.children(2) == [3]
    assert [pedigree.generation(uid) for uid in (1, 3, 5)] == [0, 1, 2]
    assert pedigree.life(5)["species"] == "deer"
    assert pedigree.life(6) is None
    assert pedigree.parents(99) == []


def test_deaths_are_noted_with_cause_and_killer():
    world = family()
    world.spawn("wolf")
    world.flush()
    pedigree = Genealogy(Journal(world))
    world.kill(1, "eaten by wolf", killer=3)
    world.kill(2, "starved")
    world.step()
    assert pedigree.died(1) == {"tick": 0, "cause": "eaten by wolf", "killer": 3}
    assert pedigree.died(2) == {"tick": 0, "cause": "starved", "killer": None}
    assert pedigree.died(3) is None
    assert pedigree.life(1)["born"] == 0


def test_the_oldest_lives_are_forgotten_before_memory_runs_out():
    world = family()
    journal = Journal(world, most=1000, size=200)
    pedigree = Genealogy(journal)
    parent = 1
    for _ in range(50):
        first = world.next_uid
        world.table("deer").request(np.full(100, parent, np.uint64), {})
        world.flush()
        parent = first
    assert journal.births.rows <= 1000
    assert [group.rows for group in journal.births.groups] == [200] * 5
    last = world.next_uid - 1
    assert pedigree.parents(last) == [last - 199]  # the first of the hundred before
    assert pedigree.life(1) is None
    assert journal.born.tolist() == [5000, 0]


def test_lives_are_entered_late_as_they_would_be_at_once():
    def lives(size):
        world = family()
        pedigree, rng = Genealogy(Journal(world, size=size)), np.random.default_rng(3)
        for _ in range(30):
            deer = world.tables["deer"]
            living = deer.uid[deer.by_uid()]
            parents, second = rng.choice(living, (2, 7))
            deer.request(parents, {}, np.where(rng.random(7) < 0.5, second, 0).astype(np.uint64))
            world.spawn("wolf", n=2)
            for uid in rng.choice(living, min(5, living.size - 1), replace=False):
                world.kill(int(uid), "starved")
            world.step()
        return [pedigree.facts(uid) for uid in range(world.next_uid)]

    at_once, late = lives(0), lives(10**9)
    assert at_once == late
    assert max(facts["generation"] or 0 for facts in late) > 5
