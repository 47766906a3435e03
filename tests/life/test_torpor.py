"""Those without energy lie still, burn nothing, and wait for food."""

import numpy as np
import pytest

from ecs_eco.components import Gestation, Metabolism, Position, Velocity
from ecs_eco.life.torpor import LEAST_ENERGY, awake
from ecs_eco.systems import Decide, Feed, Mate, Metabolise, Move, Sense
from ecs_eco.testing import act, arrange

TORPID = {"energy": 0.5, "energy_max": 1.0, "basal": 0.25, "torpor": True}
WALK = {"formulas": {"walk": "1"}}


def _energy(table):
    return table[Metabolism].energy[table.by_uid()].tolist()


def _eat(world):
    for system in (Sense, Decide, Feed):
        act(world, system)


def test_the_torpid_burn_what_they_have_and_no_more(meadow):
    world = meadow(count=4, metabolism=TORPID, lethal=[])
    deer = arrange(world, "deer", energy=[0.5, 0.125, 0, -0.5], cost=[0.125, 0, 0, 0])
    act(world, Metabolise)
    assert _energy(deer) == [0.125, 0, 0, -0.5]
    assert deer[Metabolism].burnt[deer.by_uid()].tolist() == [0.375, 0.125, 0, 0]


def test_the_torpid_lie_still_and_pay_for_no_way(meadow):
    world = meadow(metabolism=TORPID, lethal=[], reflex=WALK)
    deer = arrange(world, "deer", x=[5, 15], y=5, heading=0, energy=[0.5, 0], speed=1, cost=0.25)
    for system in (Sense, Decide, Move):
        act(world, system)
    rows = deer.by_uid()
    assert (deer[Position].x[rows] != [5, 15]).tolist() == [True, False]
    assert deer[Velocity].speed[rows[1]] == deer[Velocity].cost[rows[1]] == 0
    assert deer[Velocity].speed[rows[0]] > 0


def test_food_that_comes_into_reach_ends_torpor(meadow):
    world = meadow(metabolism=TORPID, lethal=[], grass={"count": 2})
    deer = arrange(world, "deer", x=[5, 15], y=5, energy=0)
    arrange(world, "grass", x=[5.5, 1], y=5)
    assert not awake(deer)[deer.by_uid()].any()
    _eat(world)
    assert _energy(deer) == [0.25, 0]
    assert awake(deer)[deer.by_uid()].tolist() == [True, False]


def test_bad_food_takes_no_more_than_there_is(meadow):
    world = meadow(
        count=1,
        metabolism=TORPID,
        lethal=[],
        grass={"count": 1},
        diet=[{"eats": "grass", "reach": 0.25, "gain": -0.75}],
    )
    deer = arrange(world, "deer", x=5, y=5, energy=0.5)
    arrange(world, "grass", x=5.5, y=5)
    _eat(world)
    assert _energy(deer) == [0]
    assert deer[Metabolism].taken[deer.by_uid()].tolist() == [-0.5]


def test_the_torpid_do_not_mate(meadow):
    way = {
        "kind": "sexual",
        "energy_min": 0.0,
        "energy_given": 0.25,
        "reach": 5.0,
        "consent": "none",
        "father_share": 0.0,
        "gestation": 10.0,
    }
    carrying = []
    for energy in (0.0, 0.25):
        world = meadow(metabolism=TORPID, lethal=[], reproduction=way)
        deer = arrange(world, "deer", x=[5, 6], y=5, energy=[energy, 0.5])
        act(world, Mate)
        carrying.append(int(deer[Gestation].carrying[deer.rows()].sum()))
    assert carrying == [0, 1]


def test_others_are_awake_whatever_they_have(meadow):
    world = meadow()
    deer = arrange(world, "deer", energy=-1)
    assert awake(deer) is deer.alive
    assert LEAST_ENERGY[deer.species.metabolism.torpor] == -np.inf


def test_torpor_may_begin_while_a_world_lives_and_its_books_close(meadow):
    world = meadow(metabolism=TORPID | {"torpor": False}, lethal=[])
    world.run(4)
    deer = world.tables["deer"]
    assert (deer[Metabolism].energy[deer.rows()] < 0).all()
    world.intervene({"kind": "set", "set": {"species.deer.metabolism.torpor": True}})
    before = deer[Metabolism].energy[deer.rows()].sum()
    world.run(5)
    assert deer[Metabolism].energy[deer.rows()].sum() == pytest.approx(before)
