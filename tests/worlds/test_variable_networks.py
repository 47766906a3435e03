"""Weights of networks in strings of variable length: founders have the trained ones in their letters,
children what is left of them."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Genome, Instincts, Policy
from ecs_eco.config import load
from ecs_eco.testing import check_world
from tests.worlds.herd import HERD, gene_for, goats, herd
from tests.worlds.test_coded_networks import ACTIONS, CHANNELS, FEW, linear
from tests.worlds.test_variable_genomes import RATES

BREED = HERD["species"]["goat"]["reproduction"] | {"gestation": 2.0}


def instincts():
    """Networks of weights that letters code for exactly: eat and mate whenever it can, want energy."""
    biases = np.zeros((len(ACTIONS), 3), np.float32)
    biases[[ACTIONS.index("eat"), ACTIONS.index("mate")], 2] = 1.0
    return (
        linear("reflex", np.zeros((CHANNELS, 21)), biases.ravel()),
        linear("happiness", [2.0, 0.0, 0.0, 0.0, 0.0], [0.5]),
    )


def inheriting(**more):
    """A herd whose strings of variable length hold both networks, twice the first."""
    reacts, wants = instincts()
    genes = [
        gene_for(
            "reacts",
            "reflex.weights",
            1,
            low=-1.0,
            high=2.0,
            form="direct",
            promoter="TATA",
            copies=2,
            copy_rule="mean",
        ),
        gene_for("wants", "happiness.weights", 2, low=-3.5, high=4.0, form="direct", promoter="CGCG"),
        gene_for("size", "body.radius", 3, low=0.2, high=0.6, promoter="GGAG"),
    ]
    genome = {"max_length": 600, "founders": "own", "genes": genes, **RATES, **more}
    return herd(
        components=[],
        reflex={"function": reacts},
        happiness={"function": wants, "minimum": -9.0},
        genome=genome,
        reproduction=BREED,
        count=40,
    )


@pytest.mark.definition("3 genome", "3 genome encodes")
@pytest.mark.parametrize("ploidy", [1, 2])
def test_founders_have_the_fitted_weights_in_their_letters_and_children_what_they_inherit(ploidy):
    reacts, wants = instincts()
    world = World.from_config(inheriting(ploidy=ploidy))
    table, rows = goats(world)
    assert np.array_equal(table[Instincts].reflex[rows], np.repeat(reacts.weights[None], rows.size, 0))
    assert np.array_equal(table[Instincts].happiness[rows], np.repeat(wants.weights[None], rows.size, 0))
    heredity, layout = table.species.heredity, table.species.heredity.layout
    children = heredity.offspring(
        world,
        table,
        np.repeat(rows, 5),
        np.repeat(rows[::-1], 5),
        np.arange(1, 5 * rows.size + 1, dtype=np.uint64),
    )
    loci = children[Genome, "loci"]
    values, copies = layout.decode(loci), layout.copy_numbers(loci)
    assert np.array_equal(children[Instincts, "reflex"], values["reacts"])
    assert np.array_equal(children[Instincts, "happiness"], values["wants"])
    assert set(np.unique(copies["reacts"])) > {2 * ploidy}  # some doubled, some lost
    assert (values["wants"][copies["wants"] == 0] == 0).all()
    unlike = (values["wants"] != wants.weights).any(axis=1)
    assert 0.05 < unlike.mean() < 0.95


def test_such_a_herd_keeps_its_promises():
    check_world(lambda threads: World.from_config(inheriting(ploidy=2), threads=threads), ticks=30)


def test_a_trained_policy_becomes_letters_of_founders_whose_strings_vary_in_length():
    teacher = World.from_config(load("innate", FEW), seed=2, record=False)
    table = teacher.tables["goat"]
    module = teacher.policy("goat", int(table.uid[table.by_uid()[0]]))
    longer = {
        "species.goat.genome.max_length": 1200,
        "species.goat.genome.founders": "own",
        "species.goat.genome.mate": {"operator": "cxUnequal"},
    }
    world = World.from_config(load("innate", FEW | longer), policies={"goat": module}, record=False)
    pupils, rows = goats(world)
    taught = table[Policy].weights[table.by_uid()[:1]]
    assert np.array_equal(pupils[Policy].weights[rows], np.repeat(taught, rows.size, axis=0))
