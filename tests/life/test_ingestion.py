"""Eating moves substances: by volume, mixed into the eater's body, the rest given back."""

import numpy as np
import pytest

from ecs_eco.components import Chemistry, Matter
from ecs_eco.life.ingestion import ingest
from ecs_eco.life.matter import Bodies, litres
from ecs_eco.systems import Decide, Feed, Sense
from ecs_eco.testing import act, arrange

SUBSTANCES = {"glucose": "", "salt": ""}
STONE = {"at": [[5.0, 5.0]], "body": {"radius": 0.25, "opaque": False}, "substances": {"glucose": 1.0}}


@pytest.fixture
def table_laid(meadow):
    """A function that returns a world with a stone of sugar within reach of the first of two deer."""

    def build(stone=None, world=None, diet=None, **deer):
        food = {"eats": "stone", "reach": 0.25, "gain": 0.25} | (diet or {})
        laid = {"substances": SUBSTANCES, "objects": {"stone": STONE | (stone or {})}}
        new = meadow(
            world=laid | (world or {}),
            **({"diet": [food], "substances": {"glucose": 0.5}, "body": {"radius": 0.5}} | deer),
        )
        arrange(new, "deer", x=[5.5, 15.0], y=[5.0, 15.0], energy=0.5)
        return new

    return build


def eat(world):
    for system in (Sense, Decide, Feed):
        act(world, system)


def held(world, name="deer"):
    """Concentrations of a table in the order of uids, with what float32 cannot hold: f64[n, substances]."""
    table = world.tables[name]
    rows = table.by_uid()
    out = table[Chemistry].molarity[rows].astype(float)
    return out + table[Matter].residue[rows] if Matter in table else out


def flow(world, name):
    """The flows of one kind in the open page: holder → amounts of glucose and salt [mol]."""
    from ecs_eco.life.matter import NUMBER

    return {
        holder: world.matter.flows[i, :, NUMBER[name]].tolist()
        for (_, holder), i in world.matter.holders.items()
    }


@pytest.mark.definition("3 chemical rules")
def test_the_eater_holds_what_the_eaten_held(table_laid):
    """A sphere of 0.25 m has 65.45 L, one of 0.5 m 523.6 L, eight times as much: 1 mol/L of the one is
    1/8 mol/L of the other."""
    world = table_laid()
    eat(world)
    assert held(world)[:, 0].tolist() == pytest.approx([0.625, 0.5], abs=1e-12)
    assert held(world, "stone")[0].tolist() == [0, 0]
    assert flow(world, "eaten") == {
        "deer": pytest.approx([65.449847, 0], abs=1e-6),
        "stone": pytest.approx([-65.449847, 0], abs=1e-6),
    }


def test_what_is_not_assimilated_goes_to_the_field_of_the_substance_or_is_lost(table_laid):
    world = table_laid(diet={"assimilation": 0.25})
    eat(world)
    assert held(world)[0, 0] == pytest.approx(0.5 + 0.125 / 4, abs=1e-12)
    assert flow(world, "lost")["deer"] == pytest.approx([-0.75 * 65.449847, 0], abs=1e-6)


def test_a_substance_that_the_eater_was_born_without_comes_in_too(table_laid):
    world = table_laid(stone={"substances": {"salt": 0.8}})
    eat(world)
    assert held(world).tolist() == [pytest.approx([0.5, 0.1], abs=1e-8), [0.5, 0.0]]


def test_who_holds_no_substances_takes_none_up_and_those_of_the_eaten_are_lost(table_laid):
    world = table_laid(substances={})
    world.run(1)
    assert world.tables["stone"].n == 0
    page = {k: np.array(v) for k, v in world.recorder.matter_series().to_pydict().items()}
    assert page["lost"].tolist() == pytest.approx([-65.449847, 0], abs=1e-6)
    assert page["stock_after"].tolist() == [0, 0]


def test_nobody_else_changes(table_laid):
    world = table_laid(diet={"reach": 0.0})
    arrange(world, "deer", x=[6.0, 15.0])
    eat(world)
    assert held(world)[:, 0].tolist() == [0.5, 0.5]
    assert held(world, "stone")[0].tolist() == [1, 0]


@pytest.mark.parametrize("seed", range(3))
def test_the_kernel_is_its_slow_twin(seed):
    rng = np.random.default_rng(seed)
    n, k, s = 9, 5, 3
    volume, food_volume = litres(rng.uniform(0.1, 1, n)), litres(rng.uniform(0.1, 1, n))
    molarity, food = (rng.uniform(0, 2, (n, s)).astype(np.float32) for _ in range(2))
    residue, none = np.zeros((n, s), np.float32), np.zeros((0, 0), np.float32)
    eaters, eaten = rng.permutation(n)[:k], rng.permutation(n)[:k]
    amount = food[eaten].astype(float) * food_volume[eaten, None]
    wanted = molarity.astype(float)
    wanted[eaters] += 0.4 * amount / volume[eaters, None]
    left = np.zeros((k, s))
    taken = ingest(
        eaters, eaten, 0.4, Bodies(volume, molarity, residue), Bodies(food_volume, food, none), left
    )
    assert taken == pytest.approx(amount.sum(0), rel=1e-12)
    assert molarity + residue.astype(float) == pytest.approx(wanted, rel=1e-12)
    assert left == pytest.approx(0.6 * amount, rel=1e-9)
    assert not food[eaten].any()
