"""The shipped world of goats and three grasses: what its genes do to those who have them,
and the studies' bookkeeping."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Genome, Metabolism, Policy, Position, Reflexes
from ecs_eco.config import load
from studies.common.goats import Family, carriers

GENES = ("red", "yellow", "green", "blue")
FEW = {
    "species.goat.count": 5,
    "species.red.count": 1,
    "species.yellow.count": 1,
    "species.green.count": 5,
    "species.green.reproduction.rate": 0.0,
    **{f"species.{g}.reproduction.seed_rain": 0.0 for g in GENES[:3]},
}


def at_table(dish: str) -> World:
    """Five goats that always want to eat, each alone on a tuft of the dish: one with each gene,
    and one with none."""
    world = World.from_config(
        load("reflexes", FEW | {f"species.{dish}.count": 5}), seed=1, record=False, learn=False
    )
    goats, food = world.tables["goat"], world.tables[dish]
    for name, table in world.tables.items():
        rows, p = table.rows(), table[Position]
        p.x[rows] = 10.0 * np.arange(rows.size) + 5
        p.y[rows] = 50.0 if table in (goats, food) else {"red": 10.0, "yellow": 20.0, "green": 30.0}[name]
    rows = goats.by_uid()
    goats[Reflexes].weight[rows] = 0
    for i in range(3):
        goats[Reflexes].weight[rows[i], i] = -1
    goats[Metabolism].energy[rows] = 0.5
    minds = goats.species.nerves.individuals
    weights = goats[Policy].weights[rows]
    bias = minds.views(weights)[-1]
    bias[:, 1] = 100.0  # the second option of the first group, speed, is to eat
    goats[Policy].weights[rows] = weights
    return world


@pytest.mark.parametrize("dish", GENES[:3])
def test_a_gene_keeps_its_goat_from_one_grass_alone_and_lets_it_walk_on(dish):
    world = at_table(dish)
    goats, food = world.tables["goat"], world.tables[dish]
    rows = goats.by_uid()
    uids, x, y = goats.uid[rows].copy(), goats[Position].x[rows].copy(), goats[Position].y[rows].copy()
    meals = {"red": None, "yellow": -0.04, "green": 0.12}
    world.run(1)
    assert food.n == 1  # four of five eat
    for i, uid in enumerate(uids.tolist()):
        alive = uid in goats.uid[goats.rows()]
        if GENES[i : i + 1] == (dish,):
            row = world.locate(uid)[1]
            assert goats[Metabolism].energy[row] == pytest.approx(0.498)
            assert np.hypot(goats[Position].x[row] - x[i], goats[Position].y[row] - y[i]) == pytest.approx(
                0.8, abs=1e-5
            )
        elif dish == "red":
            assert not alive
        else:
            row = world.locate(uid)[1]
            assert goats[Metabolism].energy[row] == pytest.approx(0.498 + meals[dish])
            assert (goats[Position].x[row], goats[Position].y[row]) == (x[i], y[i])  # who eats stands still
    assert "poisoned by red" in world.causes


def test_founders_carry_each_gene_with_a_chance_of_a_quarter_and_blue_says_nothing():
    founders = World.from_config("reflexes", seed=3, record=False).tables["goat"]
    rows = founders.rows()
    loci, weight = founders[Genome].loci[rows], founders[Reflexes].weight[rows]
    assert rows.size == 500
    assert (abs((loci[:, :4] == 3).mean(0) - 0.25) < 0.08).all()  # four standard errors
    assert (weight == np.where(loci[:, :3] == 3, -1, 0)).all()  # three reflexes for four genes


def test_without_a_possible_red_gene_no_goat_has_the_reflex():
    change = {"species.goat.genome.genes.0.values": [0, 0, 0, 0]}
    goats = World.from_config(load("reflexes", change), seed=3, record=False).run(30).tables["goat"]
    weight = goats[Reflexes].weight[goats.rows()]
    assert not weight[:, 0].any()
    assert weight[:, 1].any()
    assert weight[:, 2].any()


def test_goats_of_two_parents_are_born_and_die_of_red_grass():
    world = World.from_config("reflexes", seed=4, record=False)
    family = Family(world, "goat")
    world.run(220)
    lineage = family.lineage()
    assert (lineage.cause == "poisoned by red").sum() > 10
    born = lineage.parent > 0
    assert born.sum() > 50
    assert (lineage.parent2[born] > 0).all()
    assert (lineage.parent2[born] != lineage.parent[born]).all()


def test_the_family_book_counts_what_the_table_holds():
    world = World.from_config("reflexes", seed=5, record=False)
    family = Family(world, "goat")
    world.run(201)
    counts, goats = carriers(family.lineage(), 100), world.tables["goat"]
    held = goats[Genome].loci[goats.rows()] == 3
    assert counts["tick"].tolist() == [0, 100, 200]
    assert counts["n"][-1] == goats.n
    assert [counts[g][-1] for g in GENES] == held[:, :4].sum(0).tolist()
    assert counts["generation"][0] == 0
    assert counts["generation"][-1] > 0


def test_only_those_born_late_are_in_a_late_book():
    world = World.from_config("reflexes", seed=5, record=False)
    family = Family(world, "goat")
    world.run(201)
    whole, late = family.lineage(), family.lineage(since=150)
    assert late.uid.tolist() == whole.uid[whole.born >= 150].tolist()
    assert late.born.min() >= 150
