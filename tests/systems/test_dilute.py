"""A body that changes its volume neither makes matter nor loses it."""

import pytest

from ecs_eco.components import Body, Chemistry, Matter
from ecs_eco.life.matter import litres, stocks
from ecs_eco.systems import Dilute
from ecs_eco.testing import act

ROTS = [{"from": {"sugar": 1.0}, "to": {}, "rate": 1e-30}]


@pytest.fixture
def herd(meadow):
    return meadow(
        world={"substances": {"sugar": "", "salt": ""}},
        substances={"sugar": 0.5, "salt": 0.25},
        reactions=ROTS,
    )


@pytest.mark.definition("1 substances")
def test_a_body_of_twice_the_radius_holds_an_eighth_of_the_concentration(herd):
    table = herd.tables["deer"]
    before = stocks(herd, herd.matter)
    table[Body].radius[0] *= 2
    act(herd, Dilute)
    assert table[Chemistry].molarity[:2].tolist() == [[0.0625, 0.03125], [0.5, 0.25]]
    assert table[Matter].volume[:2] == pytest.approx(litres([1.0, 0.5]))
    assert stocks(herd, herd.matter) == pytest.approx(before, rel=1e-12)


def test_a_box_holds_what_its_volume_says(meadow):
    """Of 2 m × 1 m × 0.5 m: 1000 L."""
    box = {"body": {"shape": "box", "size": [2.0, 1.0, 0.5], "radius": None}}
    world = meadow(world={"substances": {"sugar": ""}}, substances={"sugar": 0.5}, reactions=ROTS, **box)
    assert world.tables["deer"][Matter].volume[:2] == pytest.approx([1000, 1000], rel=1e-6)
    assert stocks(world, world.matter)[0] == pytest.approx([1000], rel=1e-6)


def test_a_box_leaves_its_amounts_to_a_sphere(meadow):
    box = {"body": {"shape": "box", "size": [2.0, 1.0, 0.5], "radius": None}, "remains": "bone"}
    world = meadow(
        world={"substances": {"sugar": ""}, "objects": {"bone": {"body": {"radius": 0.1}}}},
        substances={"sugar": 0.5},
        lethal=[{"property": "age", "max": 1.5}],
        **box,
    )
    for _ in range(4):
        world.run(1)
        assert stocks(world, world.matter).sum() == pytest.approx(1000, rel=1e-6)
    assert world.tables["bone"].n == 2


def test_newborn_have_the_volume_of_their_bodies(herd):
    herd.spawn("deer", Body(radius=0.25))
    herd.flush()
    volume = herd.tables["deer"][Matter].volume
    assert volume[:3] == pytest.approx(litres([0.5, 0.5, 0.25]))
