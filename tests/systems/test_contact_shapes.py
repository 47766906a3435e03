"""Eating, mating, being born and leaving remains where bodies are capsules and boxes."""

import math

import numpy as np
import pytest

from ecs_eco.components import Body, Matter, Metabolism, Parentage, Physical, Position, Shape
from ecs_eco.life.places import around, find_places
from ecs_eco.systems import Collide, Decide, ExchangeHeat, Feed, LeaveRemains, Mate, Nurse, Sense
from ecs_eco.testing import act, arrange, check_system
from tests.systems.couples import FEMALE, MALE, WAY, mate

LONG = {"shape": "capsule", "radius": 0.25, "length": 3.0}


def _energy(world):
    table = world.tables["deer"]
    return table[Metabolism].energy[table.by_uid()].tolist()


@pytest.mark.definition("1 conformation")
def test_reach_is_measured_from_surface_to_surface(meadow):
    world = meadow(count=4, body=LONG, grass={"count": 4, "body": {"radius": 0.25}})
    # reach 0.25: before the nose, too far before it, beside it and too far aside
    arrange(world, "deer", x=[3, 9, 15, 3], y=[3, 3, 3, 12], heading=0, energy=0.5)
    arrange(world, "grass", x=[4.95, 11.05, 14, 3], y=[3, 3, 3.7, 12.8])
    for system in (Sense, Decide, Feed):
        act(world, system)
    assert _energy(world) == [0.75, 0.5, 0.75, 0.5]


@pytest.mark.definition("1 conformation")
def test_a_box_is_eaten_at_its_nearest_side(meadow):
    hedge = {
        "objects": {
            "hedge": {"at": [[10.0, 10.0], [10.0, 13.0]], "body": {"shape": "box", "size": [8.0, 1.0]}}
        }
    }
    world = meadow(world=hedge, diet=[{"eats": "hedge", "reach": 0.25, "gain": 0.25}])
    arrange(world, "deer", x=[6.5, 13.5], y=[11.2, 11.3], energy=0.5)  # 0.2 m and 0.3 m from the first hedge
    arrange(world, "hedge", heading=0)
    for system in (Sense, Decide, Feed):
        act(world, system)
    assert _energy(world) == [0.75, 0.5]
    table = world.tables["hedge"]
    assert (table.cause[table.by_uid()] > 0).tolist() == [True, False]


@pytest.mark.definition("1 conformation")
@pytest.mark.parametrize(
    ("y", "heading", "meets"),
    [(1.45, 0.0, True), (1.55, 0.0, False), (2.7, math.pi / 2, True), (2.8, math.pi / 2, False)],
)
def test_mates_reach_each_other_from_surface_to_surface(meadow, y, heading, meets):
    world = meadow(sex="random", reproduction=WAY, body=LONG)  # reach 1 m
    arrange(world, "deer", x=10.0, y=[5.0, 5.0 + y], heading=[0.0, heading], sex=[FEMALE, MALE], energy=0.75)
    assert mate(world) == ({0: 1} if meets else {})


def test_nobody_is_born_within_a_building(meadow):
    house = {"objects": {"house": {"at": [[10.0, 10.0]], "body": {"shape": "box", "size": [6.0, 12.0]}}}}
    way = {"kind": "asexual", "rate": 0.5, "energy_min": 0.1, "energy_given": 0.05, "dispersal": 4.0}
    world = meadow(count=60, world=house, reproduction=way, body={"radius": 0.5, "opaque": False})
    deer = arrange(world, "deer", x=6.9, y=np.linspace(5, 15, 60))
    arrange(world, "house", heading=0)
    rows = deer.by_uid()
    way = around(deer, world.config.species["deer"].reproduction, rows)
    places = find_places(deer, world, way, deer.uid[rows])
    free = places[places[:, 3] > 0]
    assert len(free) > 50
    within = (abs(free[:, 0] - 10) < 3.49) & (abs(free[:, 1] - 10) < 6.49)
    corner = np.hypot(np.maximum(abs(free[:, 0] - 10) - 3, 0), np.maximum(abs(free[:, 1] - 10) - 6, 0)) < 0.49
    assert not (within & corner).any()
    assert (abs(free[:, 0] - 10) < 7).any()  # the house is no disc


def test_remains_have_the_shape_of_the_dead(meadow):
    carcass = {"objects": {"carcass": {"body": {"radius": 0.1}}}}
    world = meadow(world=carcass, body=LONG, remains="carcass")
    deer = arrange(world, "deer", x=[3, 9], y=5, heading=[0.5, 1.5])
    first = deer.by_uid()[0]
    deer.cause[first] = world.cause("cold")
    act(world, LeaveRemains)
    world.flush()
    left = world.tables["carcass"]
    row = left.by_uid()[0]
    assert (left[Body].radius[row], left[Position].heading[row]) == pytest.approx((0.25, 0.5))
    assert (left[Shape].half_length[row], left[Shape].rounding[row]) == (5, 1)


@pytest.mark.definition("1 conformation")
def test_a_long_body_cools_by_its_own_surface(meadow):
    heat = {
        "properties": {"temperature": 310.0},
        "heat": {"specific_heat": 1000.0, "conductance": 10.0},
        "metabolism": {"energy": 0.5, "basal": 0.0},
    }
    world = meadow(body=LONG | {"mass": 2.0}, **heat)
    act(world, ExchangeHeat)
    area = math.pi * (2 * 0.25 * 2.5 + 4 * 0.25**2)
    table = world.tables["deer"]
    expected = 285 + 25 * math.exp(-10 * area / 2000)
    assert table[Physical].temperature[table.rows()] == pytest.approx([expected] * 2, abs=1e-3)


@pytest.mark.definition("1 conformation", "1 substances")
def test_amounts_of_substances_go_by_the_volume_of_the_shape(meadow):
    salt = {"substances": {"salt": "NaCl"}, "fields": {"brine": {"cell": 2.0, "substance": "salt"}}}
    ways = [{"kind": "release", "substance": "salt", "field": "brine", "rate": 0.1}]
    world = meadow(world=salt, body=LONG, substances={"salt": 0.2}, exchange=ways)
    volume = 1000 * math.pi * (0.25**2 * 2.5 + 0.25**3 * 4 / 3)
    matter = world.tables["deer"][Matter].volume
    assert matter[world.tables["deer"].rows()] == pytest.approx([volume] * 2, rel=1e-6)


@pytest.mark.definition("1 conformation")
def test_young_are_fed_from_surface_to_surface(meadow):
    care = {"by": "mother", "age_max": 100.0, "rate": 0.1, "reach": 0.3}
    way = {"kind": "asexual", "rate": 0.1, "energy_min": 0.1, "energy_given": 0.05, "dispersal": 8.0}
    world = meadow(count=3, body=LONG, care=care, reproduction=way)
    deer = arrange(
        world, "deer", x=[10, 10, 10], y=[10, 10.7, 10.9], heading=0, energy=[0.9, 0.2, 0.2], age=[500, 1, 1]
    )
    mother = deer.uid[deer.by_uid()[0]]
    deer[Parentage].mother[deer.by_uid()[1:]] = mother
    act(world, Nurse)
    energy = deer[Metabolism].energy[deer.by_uid()]
    assert energy[1] > 0.2
    assert energy[2] == pytest.approx(0.2)


def test_the_systems_conform_with_shapes(meadow):
    def make(threads):
        body = {"shape": "box", "size": [5.0, 0.5], "solid": True}
        hedge = {"objects": {"hedge": {"count": 6, "body": body}}}
        return meadow(
            count=60,
            world=hedge,
            sex="random",
            body=LONG | {"solid": True},
            reproduction=WAY,
            grass={"count": 40, "body": {"shape": "capsule", "length": 1.0}},
            options={"threads": threads},
        )

    for system in (Feed, Mate, Collide):
        check_system(system, make, ticks=3)
