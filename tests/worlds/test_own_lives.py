"""Organisms that differ by their genes: in pace, size, eyes, joys, spans of life and learning."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import (
    Biology,
    Body,
    Defence,
    Genome,
    Growth,
    HappinessWeights,
    LearningRates,
    LifeHistory,
    Metabolism,
    Nervous,
    Policy,
    Position,
    Reflexes,
    Senses,
    SpeedScale,
    Velocity,
)
from ecs_eco.config import load
from tests.worlds.herd import HERD, gene_for, goats, herd


def test_plants_differ_in_what_their_genes_say():
    world = World.from_config(HERD)
    grass = world.tables["grass"]
    rows = grass.rows()
    assert len(np.unique(grass[Growth].growth[rows])) == 8
    before = grass[Metabolism].energy[rows].copy()
    from ecs_eco.systems import Grow

    grow = next(s for s in world.systems if isinstance(s, Grow))
    grow.update(grass, world)
    left = 1 - 0.5 * (grass[Defence].toughness[rows] + grass[Defence].poison[rows])
    assert grass[Metabolism].energy[rows] - before == pytest.approx(
        grass[Growth].growth[rows] * left, abs=1e-6
    )


def test_who_is_faster_pays_with_the_square():
    gene = gene_for("legs", "locomotion.pace", 1, values=[0.5, 1, 1.5, 2])
    config = herd(reflex={"formulas": {"walk": "1", "still": "-1"}}, genome={"loci": 4, "genes": [gene]})
    world = World.from_config(config, policies="random").run(1)
    table, rows = goats(world)
    pace = table[SpeedScale].pace[rows]
    assert set(pace.tolist()) == {0.5, 1, 1.5, 2}
    assert table[Velocity].speed[rows] == pytest.approx(0.8 * pace)
    assert table[Velocity].cost[rows] == pytest.approx(0.004 * pace**2)


def test_large_bodies_burn_more_by_the_three_quarters_power():
    gene = gene_for("mass", "body.mass", 1, values=[50, 100, 200, 400])
    config = herd(policy={"kind": "none"}, ppo={}, genome={"loci": 4, "genes": [gene]})
    world = World.from_config(config).run(1)
    table, rows = goats(world)
    assert table[Metabolism].burnt[rows] == pytest.approx(
        0.004 * (table[Body].mass[rows] / 50) ** 0.75, rel=1e-5
    )


@pytest.mark.definition("3 hyperparameters", "3 staying alive")
def test_each_dies_at_an_age_of_its_own():
    config = herd(
        genome={"loci": 4, "genes": [gene_for("span", "life.age_max", 1, values=[5, 10, 15, 20])]},
        reproduction=None,
        count=40,
        actions={"speed": ["still", "walk"], "turn": ["left", "none", "right"], "eat": ["eat"]},
        lethal=[{"property": "age", "max": 10.0, "cause_above": "too old"}],
    )
    world, died = World.from_config(config), []
    world.on_death.append(
        lambda table, rows: (
            died.extend(zip(table[Biology].age[rows], table[LifeHistory].age_max[rows], strict=True))
            if table.name == "goat"
            else None
        )
    )
    world.run(25)
    assert len(died) == 40
    assert all(age == span for age, span in died)


@pytest.mark.definition("3 hyperparameters", "5 learning")
def test_each_learns_with_hyperparameters_of_its_own():
    gene = gene_for("rate", "ppo.learning_rate", 1, values=[0.0, 0.0, 0.05, 0.05])
    world = World.from_config(herd(genome={"loci": 4, "genes": [gene]}))
    table, rows = goats(world)
    before, uids = table[Policy].weights[rows], table.uid[rows]
    world.run(12)
    now, still = table.rows(), []
    for row in now[table.born[now] == 0]:
        unchanged = np.array_equal(
            table[Policy].weights[int(row)], before[np.flatnonzero(uids == table.uid[row])[0]]
        )
        still.append((table[LearningRates].learning_rate[row] == 0, unchanged))
    assert {s[0] for s in still} == {True, False}
    assert all(frozen == unchanged for frozen, unchanged in still)


@pytest.mark.definition("5 evolution alone", "5 learning")
def test_in_life_the_policy_changes_but_neither_reflex_nor_happiness():
    world = World.from_config(HERD)
    table, rows = goats(world)
    before = {int(table.uid[row]): _networks(table, row) for row in rows}
    world.run(20)
    lived = table.rows()
    learnt = [row for row in lived[table[Policy].updates[lived] > 0] if int(table.uid[row]) in before]
    assert len(learnt) > 5
    for row in learnt:
        was = before[int(table.uid[row])]
        assert [np.array_equal(a, b) for a, b in zip(_networks(table, row), was, strict=True)] == [
            False,
            True,
            True,
            True,
        ]


def _networks(table, row):
    """Copies of what an animal's networks are made of: policy, reflexes and their thresholds, happiness."""
    own = table[Reflexes]
    return [
        column[row].copy()
        for column in (table[Policy].weights, own.weight, own.threshold, table[HappinessWeights].weight)
    ]


def test_happiness_is_what_the_own_weights_make_of_the_senses():
    world = World.from_config(HERD, policies="random").run(1)
    table = world.tables["goat"]
    nerves = table.species.nerves
    energy, musk = nerves.reading("energy", nerves.x), nerves.reading("musk", nerves.x)
    weight = table[HappinessWeights].weight[nerves.rows]
    wanted = np.maximum(weight[:, 0] * energy + weight[:, 1] * musk, -1)
    alive = table.alive[nerves.rows]
    assert table[Nervous].happiness[nerves.rows][alive] == pytest.approx(wanted[alive], abs=1e-6)
    assert weight[:, 0].std() > 0.1


def test_each_sees_as_far_as_its_own_eyes():
    config = load(HERD)
    goat = World.from_config(config, policies="random").run(1).tables["goat"]
    nerves, own = goat.species.nerves, goat[Senses].radius
    near = nerves.reading("grass_near", nerves.x)
    # as they stood when they sensed, before anyone moved or was eaten
    before = World.from_config(config, policies="random")
    p, q, plants = (
        before.tables["goat"][Position],
        before.tables["grass"][Position],
        before.tables["grass"].rows(),
    )
    for i, row in enumerate(nerves.rows):
        dx, dy = (np.abs(getattr(q, a)[plants] - getattr(p, a)[row]) for a in ("x", "y"))
        distance = np.sqrt(np.minimum(dx, 30 - dx) ** 2 + np.minimum(dy, 30 - dy) ** 2).min()
        assert near[i] == pytest.approx(max(0.0, 1 - distance / own[row, 1]), abs=1e-3)
    assert 0.1 < (near > 0).mean() < 1


@pytest.mark.parametrize("options", [{"policies": "random"}, {"training": True, "learn": True}])
def test_genes_of_a_brain_say_nothing_where_nobody_has_one_of_its_own(options):
    brain = gene_for("brain", "policy.weights", 3, low=-1.0, high=1.0, form="cosine", coefficients=3)
    config = herd(policy={"kind": "individual", "hidden": [6], "inherit": "birth"}, genome={"genes": [brain]})
    world = World.from_config(config, **options).run(20)
    goat = world.tables["goat"]
    assert Policy not in goat
    assert goat[Genome].loci.any()
    assert (goat.species.nerves.brain is None) == ("policies" in options)
