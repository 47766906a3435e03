"""Weights that are inherited: learned ones of parents, those of the dead, those trained by all."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Genome, Policy
from tests.worlds.herd import HERD, F, herd


def test_children_start_from_a_parents_learned_weights():
    world = World.from_config(
        herd(policy=HERD["species"]["goat"]["policy"] | {"mutation_sd": 0.0}), learn=False
    )
    goat, seen = world.tables["goat"], []

    def born(table, rows, first, second):
        if table is goat:
            for row, *parents in zip(rows, first, second, strict=True):
                weights = [
                    table[Policy].weights[int(r)] for u in parents for r in np.flatnonzero(table.uid == u)
                ]
                seen.append([bool((table[Policy].weights[int(row)] == w).all()) for w in weights])

    world.on_birth.append(born)
    world.run(60)
    both = [s for s in seen if len(s) == 2]
    assert len(both) > 15
    assert all(any(s) for s in both)
    assert 0.2 < np.mean([s[0] for s in both]) < 0.8  # the mother's or the father's


def test_inherited_weights_get_noise_of_the_declared_size():
    world = World.from_config(
        herd(policy=HERD["species"]["goat"]["policy"] | {"mutation_sd": 0.25}), learn=False
    )
    table = world.tables["goat"]
    heredity, rows = table.species.heredity, table.rows()
    first = np.full(200, rows[0])
    values = heredity.offspring(world, table, first, None, np.arange(1, 201, dtype=np.uint64))
    noise = values[Policy, "weights"] - table[Policy].weights[int(rows[0])]
    assert noise.mean() == pytest.approx(0, abs=0.01)
    assert noise.std() == pytest.approx(0.25, rel=0.03)
    assert len(np.unique(noise[:, 0])) == 200


def test_a_dead_father_leaves_genes_and_no_brain():
    world = World.from_config(
        herd(policy=HERD["species"]["goat"]["policy"] | {"mutation_sd": 0.0}), learn=False
    )
    table = world.tables["goat"]
    heredity, rows = table.species.heredity, table.rows()
    sperm = np.full((50, table[Genome].loci.shape[1]), 3, np.uint8)
    mothers, dead = np.full(50, rows[0]), np.full(50, -1)
    values = heredity.offspring(world, table, mothers, dead, np.arange(50, dtype=np.uint64), sperm=sperm)
    assert (values[Policy, "weights"] == table[Policy].weights[int(rows[0])]).all()
    assert 0.3 < (values[Genome, "loci"] == 3).mean() < 0.9


def test_a_brain_trained_by_all_is_where_individuals_start():
    from ecs_eco.learning import PPO, Brain
    from ecs_eco.learning.individual import Individuals

    for hidden in ((5,), (6, 4)):
        brain = Brain(3, (2, 4), hidden, seed=4)
        for tensor in brain.named().values():
            tensor[...] += np.random.default_rng(1).normal(size=tensor.shape).astype(F)
        minds = Individuals(3, (2, 4), hidden, PPO(), 1)
        world = World(seed=1)
        table = world.add_table("one", Policy, dims={"weights": minds.size})
        rows = table.occupy(20, 1, 0, {(Policy, "weights"): np.repeat(minds.flat(brain)[None], 20, 0)})
        x = np.random.default_rng(2).normal(size=(20, 3)).astype(F)
        for mine, theirs in zip(
            minds.forward(table[Policy], rows, x, world.split), brain.forward(x), strict=True
        ):
            assert mine == pytest.approx(theirs, abs=1e-5)
