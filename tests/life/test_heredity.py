"""Worlds in which genomes make bodies, senses, nerves and lives: what newborn are,
and what holds whatever they are."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import (
    Body,
    Experience,
    Genome,
    HappinessWeights,
    LifeHistory,
    Nervous,
    Policy,
    Reflexes,
    Senses,
)
from ecs_eco.engine.errors import ConfigError
from ecs_eco.testing import all_threads, check_world, difference, shuffle, state
from tests.worlds.herd import HERD, F, Wool, gene_for, goats, herd


@pytest.mark.slow
def test_a_herd_with_genes_for_everything_keeps_its_promises():
    check_world(lambda threads: World.from_config(HERD, threads=threads), ticks=60)


@pytest.mark.parametrize(
    "goat",
    [
        {
            "policy": {"kind": "individual", "hidden": [4], "learn": True, "inherit": "none"},
            "reproduction": {"kind": "asexual", "rate": 0.05, "energy_min": 0.5, "energy_given": 0.2},
            "sex": "none",
            "actions": {"speed": ["still", "walk"], "turn": ["left", "none", "right"], "eat": ["eat"]},
            "genome": {
                "ploidy": 2,
                "expression": "mean",
                "genes": [gene_for("size", "body.radius", low=0.2, high=0.6)],
            },
        },
        {
            "policy": {"kind": "individual", "hidden": [4], "learn": True, "inherit": "birth"},
            "genome": {
                "mate": {"operator": "cxUniform", "indpb": 0.3},
                "mutate": {"operator": "mutShuffleIndexes", "indpb": 0.02},
                "genes": [gene_for("brain", "policy.weights", 3, low=-1.0, high=1.0, form="direct")],
            },
        },
    ],
    ids=["diploid and asexual", "a brain in the genome"],
)
def test_other_ways_to_inherit_keep_their_promises(goat):
    check_world(lambda threads: World.from_config(herd(**goat), threads=threads), ticks=40)


def test_learning_alone_is_the_same_in_any_order_of_rows_and_on_two_threads():
    one = World.from_config(herd(count=150)).run(40)
    table, rows = goats(one)
    assert table[Policy].updates[rows].max() >= 4
    mixed = shuffle(World.from_config(herd(count=150)), 3).run(40)
    assert difference(state(one), state(mixed)) == ""
    with all_threads():
        assert World.from_config(herd(count=150), threads=2).run(40).digest() == one.digest()


@pytest.mark.definition("3 genome encodes")
def test_a_newborn_is_what_its_genome_says():
    world = World.from_config(HERD).run(60)
    for name in ("goat", "grass"):
        table = world.tables[name]
        rows = table.rows()[table.born[table.rows()] > 0]
        assert rows.size > 10
        heredity = table.species.heredity
        decoded = heredity.layout.decode(table[Genome].loci[rows])
        for gene, (kind, field, index) in heredity.targets.items():
            column = table.field(kind, field)[rows]
            assert np.array_equal(
                column if index is None else column[:, index], decoded[gene].astype(column.dtype)
            ), gene
    goat = world.tables["goat"]
    assert (goat[Reflexes].weight[goat.rows(), 1] == 1).all()  # no gene changes the other connection
    assert (goat[HappinessWeights].weight[goat.rows(), 1] == F(0.1)).all()
    assert (goat[Senses].radius[goat.rows(), 0] == 0).all()  # the sense of the own energy has no range
    assert goat[Wool].length[goat.rows()].std() > 0.01


@pytest.mark.definition("3 reproduction", "3 genome inherited")
def test_genes_cross_and_mutate_and_letters_come_from_the_parents():
    world = World.from_config(herd(reproduction=HERD["species"]["goat"]["reproduction"] | {"gestation": 0.0}))
    goat, seen = world.tables["goat"], []

    def born(table, rows, first, second):
        if table is goat:
            for row, a, b in zip(rows, first, second, strict=True):
                mother, father = (table[Genome].loci[np.flatnonzero(table.uid == u)[0]] for u in (a, b))
                child = table[Genome].loci[row]
                seen.append(((child == mother) | (child == father), child != mother, child != father))

    world.on_birth.append(born)
    world.run(60)
    known = np.array([s[0] for s in seen])
    assert len(seen) > 20
    assert 0.985 < known.mean() < 0.999  # 0.01 a locus draws a letter anew; some draws are a parent's
    assert np.array([s[1].any() and s[2].any() for s in seen]).mean() > 0.5


def test_without_mutation_every_letter_is_a_parents():
    world = World.from_config(HERD, controls=("no-mutation",))
    loci = world.tables["goat"][Genome].loci
    start = [set(loci[world.tables["goat"].rows(), j].tolist()) for j in range(loci.shape[1])]
    world.run(60)
    table, rows = goats(world)
    assert all(set(table[Genome].loci[rows, j].tolist()) <= start[j] for j in range(loci.shape[1]))


def test_in_neutral_drift_genes_say_nothing():
    world = World.from_config(HERD, controls=("neutral-drift",)).run(40)
    table, rows = goats(world)
    assert (table[Reflexes].weight[rows, 0] == 0).all()
    assert (table[Body].radius[rows] == F(0.4)).all()
    assert (table[LifeHistory].age_max[rows] == 70).all()
    assert len(np.unique(table[Genome].loci[rows], axis=0)) > 20


def test_a_shuffled_genome_is_no_parents():
    def likeness(controls):
        world, alike = World.from_config(HERD, controls=controls), []
        goat = world.tables["goat"]

        def born(table, rows, first, second):
            if table is goat:
                for row, uid in zip(rows, first, strict=True):
                    mother = np.flatnonzero(table.uid == uid)
                    alike.extend((table[Genome].loci[row] == table[Genome].loci[m]).mean() for m in mother)

        world.on_birth.append(born)
        world.run(60)
        return np.mean(alike)

    assert likeness(()) > 0.55
    assert likeness(("shuffled-genome",)) < 0.45


def test_without_reflexes_nobody_has_one():
    world = World.from_config(HERD, controls=("no-reflexes",)).run(2)
    assert world.tables["goat"].species.nerves.reflex is None


def test_an_unknown_control_names_the_nearest():
    with pytest.raises(ConfigError, match='did you mean "no-mutation"'):
        World.from_config(HERD, controls=("no-mutations",))


def test_founders_may_be_alike_and_say_what_the_species_is():
    section = HERD["species"]["goat"]["genome"] | {"founders": "own"}
    section["genes"] = [
        g | ({"low": 0.01, "high": 0.64} if g["name"] == "size" else {})
        for g in section["genes"]
        if g["name"] in ("size", "green")
    ]
    world = World.from_config(herd(genome=section))
    table, rows = goats(world)
    coded = table.species.heredity.layout.coded()
    assert len(np.unique(table[Genome].loci[rows][:, coded], axis=0)) == 1
    assert table[Body].radius[rows] == pytest.approx(0.4, abs=0.005)
    assert (table[Reflexes].weight[rows, 0] == 0).all()


def test_a_row_that_is_reused_has_nothing_of_the_dead():
    world = World.from_config(herd(count=40)).run(6)
    table, rows = goats(world)
    dead = rows[:10]
    assert (table[Experience].length[dead] > 0).any()
    moment = table[Policy].moment_2[dead]
    table.cause[dead] = 1
    world._flush_deaths()
    heredity = table.species.heredity
    values = heredity.founders(world, table, np.arange(10, dtype=np.uint64))
    table.request(np.zeros(10, np.uint64), values)
    world._flush_births()
    new = np.flatnonzero(table.alive & (table.born == world.tick))
    assert sorted(new) == sorted(dead)
    assert moment.any()
    for column in (
        table[Experience].length,
        table[Experience].observations,
        table[Policy].moment_1,
        table[Policy].moment_2,
        table[Policy].steps,
        table[Nervous].awake,
    ):
        assert not np.asarray(column[new]).any()
    assert np.array_equal(table[Policy].weights[new], values[Policy, "weights"])
