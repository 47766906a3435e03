"""The shipped world of goats whose genome holds the weights of their policy."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Genome, Policy
from ecs_eco.config import load

FEW = {"species.goat.count": 120, "species.green.count": 2500}


def brains(world):
    """The rows of goats in the order of uids, their weights, and those that their letters code for."""
    goats = world.tables["goat"]
    rows = goats.by_uid()
    decoded = goats.species.heredity.layout.decode(goats[Genome].loci[rows], ["brain"])["brain"]
    return rows, goats[Policy].weights[rows], decoded


@pytest.mark.definition("3 genome encodes", "3 policy")
def test_a_newborns_policy_is_what_its_own_letters_code_for():
    world = World.from_config(load("innate", FEW), record=False)
    _, weights, decoded = brains(world)
    assert np.array_equal(weights, decoded)  # founders
    assert len(np.unique(weights, axis=0)) == 120
    seen = []

    def born(table, rows, first, second):
        if table.name == "goat":
            decoded = table.species.heredity.layout.decode(table[Genome].loci[rows], ["brain"])["brain"]
            seen.append(np.array_equal(table[Policy].weights[rows], decoded))

    world.on_birth.append(born)
    world.run(140)
    assert len(seen) >= 10
    assert all(seen)


@pytest.mark.definition("5 evolution alone")
def test_what_a_goat_learns_is_in_nobodys_letters():
    """Of two equal worlds one learns: its goats' weights leave what their letters say, which are the same."""
    learns, does_not = (
        World.from_config(load("innate", FEW), learn={"goat": learn}, record=False).run(60)
        for learn in (True, False)
    )
    rows, weights, decoded = brains(learns)
    old = learns.tables["goat"].born[rows] == 0
    assert (np.abs(weights - decoded).max(axis=1) > 0.01)[old].mean() > 0.9
    _, fixed, born_with = brains(does_not)
    assert np.array_equal(fixed, born_with)  # who does not learn is as it was born
    parent = learns.tables["goat"]
    heredity, first = parent.species.heredity, np.full(50, rows[0])
    children = heredity.offspring(learns, parent, first, first, np.arange(1, 51, dtype=np.uint64))
    letters = children[Genome, "loci"]
    same = letters == parent[Genome].loci[rows[0]]
    assert same.mean() > 0.99  # letters are the parent's but for mutations, whatever it has learnt
    assert np.array_equal(children[Policy, "weights"], heredity.layout.decode(letters, ["brain"])["brain"])


def test_it_resumes_with_equal_bytes_with_learning_and_without(tmp_path):
    for learn in (True, False):
        world = World.from_config(load("innate", FEW), learn={"goat": learn}, record=False).run(45)
        path = tmp_path / f"{learn}.checkpoint"
        world.save(path)
        assert World.restore(path, record=False).run(40).digest() == world.run(40).digest()


@pytest.mark.slow
@pytest.mark.parametrize("learn", [True, False])
def test_goats_live_on_with_learning_and_without(learn):
    world = World.from_config("innate", seed=3, learn={"goat": learn}, record=False).run(1500)
    assert world.tables["goat"].n > 100
