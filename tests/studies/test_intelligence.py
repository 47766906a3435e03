"""Does learning evolve where the past of a life predicts more? The study's statistics and its world, by hand."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Metabolism, Nervous
from ecs_eco.config import load
from ecs_eco.testing import act
from studies import intelligence


def run(arm, cell, seed, **result):
    case = {"arm": arm, "within": cell[0], "between": cell[1], "seed": seed}
    return {"case": case, "result": result}


def test_without_changes_both_pasts_predict_the_present_and_a_fair_draw_ends_that():
    assert intelligence.pasts(0.0, 0.0) == (1.0, 1.0)
    assert intelligence.pasts(0.0, 0.25) == (1.0, 0.5)
    life, line = intelligence.pasts(0.5, 0.0)
    assert life == 0.0
    assert line == pytest.approx(1 / sum(0.992**age for age in range(300)))  # only newborns know


def test_the_effect_is_the_rate_at_life_minus_the_mean_of_the_others():
    rates = {intelligence.LIFE: -1.5, intelligence.LINE: -2.5, intelligence.NEITHER: -3.0}
    cases = [run("off", cell, seed, rate=rate) for cell, rate in rates.items() for seed in (1, 2)]
    cases.append(run("map", intelligence.LIFE, 1, rate=0.0))
    assert intelligence.effect(cases, "off") == {1: 1.25, 2: 1.25}


def test_the_sign_compares_cells_where_life_predicts_more_with_the_others():
    known = np.array([[1.0, 0.0], [1.0, 0.75], [1.0, 0.8], [0.0, 0.0]])
    assert intelligence.sign(np.array([-1.0, -2.0, -3.0, -4.0]), known) == 2.0
    assert intelligence.order(np.array([-1.0, -2.0, -3.0, -4.0]), known) == 1.0


@pytest.fixture
def world():
    changes = {"species.forager.count": 4, "species.forager.age": [0.0, 0.0], "systems.Forage.accident": 0.0}
    return World.from_config(load(intelligence.WORLD, changes), seed=1, trust=True, record=False)


def component_of(table, name):
    return table[next(component for component in table.columns if component.__name__ == name)]


def test_a_forager_gains_its_share_only_at_the_good_place(world):
    foragers = world.table("forager")
    food, energy = component_of(foragers, "Food"), foragers[Metabolism].energy
    food.left[:4], food.good[:4] = [1, 1, -1, -1], [1, -1, 1, -1]
    energy[:4] = 0.5
    foragers[Nervous].decision[:4] = [[1, 0]] * 4  # all go to the left
    act(world, next(type(system) for system in world.systems if type(system).__name__ == "Forage"))
    assert food.worth[:4].tolist() == [1, 0, 0, 1]
    assert energy[:4] == pytest.approx([0.9, 0.5, 0.5, 0.9])  # 1.6 / 4 each
    assert foragers[Metabolism].taken[:4] == pytest.approx([0.4, 0, 0, 0.4])


def test_newborns_have_the_good_place_of_their_mothers_birth(world):
    foragers = world.table("forager")
    food = component_of(foragers, "Food")
    food.native[:4], food.good[:4] = [1, -1, 1, -1], [-1, 1, -1, 1]
    forage = next(system for system in world.systems if type(system).__name__ == "Forage")
    mothers = foragers.uid[[1, 0]].copy()
    forage.born(foragers, np.array([2, 3]), mothers, mothers)
    assert food.native[:4].tolist() == [1, -1, -1, 1]
    assert food.good[2:4].tolist() == [-1, 1]
    forage.between = 1.0
    forage.born(foragers, np.array([2, 3]), mothers, mothers)
    assert food.native[2:4].tolist() == [1, -1]
