import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Position, Route
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.systems import Drift, Travel
from ecs_eco.testing import act, arrange


def _yard(at=((2.0, 2.0),), size=(20.0, 10.0), dt=1.0, edges="torus", body=None, **cart):
    return {
        "format": 1,
        "name": "yard",
        "dt": dt,
        "space": {"size": list(size), "edges": edges},
        "objects": {"cart": {"at": [list(a) for a in at], "body": {"radius": 0.5} | (body or {})} | cart},
        "species": {
            "ox": {
                "count": 1,
                "body": {"radius": 0.5, "solid": True},
                "locomotion": {"speed": {"walk": 1.0}},
                "sensors": [{"kind": "own", "property": "age"}],
                "actions": {"speed": ["walk"]},
            }
        },
    }


def _place(world, name="cart"):
    p = world.tables[name][Position]
    return [pytest.approx(v, abs=1e-5) for v in (float(p.x[0]), float(p.y[0]))]


@pytest.mark.definition("2 moves")
def test_a_cart_rolls_with_its_velocity_and_around_a_torus():
    world = World.from_config(_yard(motion={"velocity": [6.0, -1.0]}, dt=0.5))
    act(world, Travel)
    assert _place(world) == [5.0, 1.5]
    for _ in range(6):
        act(world, Travel)
    assert _place(world) == [3.0, 8.5]


@pytest.mark.parametrize(
    "motion", [{"velocity": [0.0, -1.0]}, {"path": [[2.0, 0.5], [2.0, 0.4]], "speed": 0.5}]
)
def test_the_heading_of_what_travels_and_of_what_stands_is_within_the_circle(motion):
    config = _yard(heading=[-0.5]) | {"ticks": 2}
    config["objects"]["wagon"] = config["objects"]["cart"] | {"motion": motion}
    world = World.from_config(config)
    assert float(world.tables["cart"][Position].heading[0]) == pytest.approx(2 * np.pi - 0.5)
    world.run(2)
    assert float(world.tables["wagon"][Position].heading[0]) == pytest.approx(1.5 * np.pi)
    before = world.digest()
    assert World.from_config(config).run(1).run(1).digest() == before


def test_walls_rocks_and_fences_stop_it():
    config = _yard(at=[[17.0, 2.0], [2.0, 5.0], [2.0, 8.0]], edges="walls", motion={"velocity": [2.0, 0.0]})
    config["terrain"] = {"cell": 0.5, "rocks": [{"at": [10.0, 5.0], "radius": 2.0}]}
    config["interventions"] = [{"kind": "fence", "at": 0, "line": [[6.0, 7.0], [6.0, 9.5]]}]
    world = World.from_config(config).run(20)
    x = world.tables["cart"][Position].x[:3]
    assert 19.5 < x[0] < 20
    assert x[1] == 6  # the rock begins at 8: another step would end in it
    assert x[2] == 4


def test_a_solid_box_stops_a_solid_cart_and_no_other():
    for solid, places in ((True, [[4.0, 5.0], [8.0, 2.0]]), (False, [[8.0, 5.0], [8.0, 2.0]])):
        config = _yard(at=[[4.0, 5.0], [4.0, 2.0]], motion={"velocity": [4.0, 0.0]}, body={"solid": solid})
        config["objects"]["hedge"] = {
            "between": [[6.0, 4.0, 6.0, 6.0]],
            "body": {"shape": "box", "size": [1.0, 0.2], "solid": True},
        }
        world = World.from_config(config)
        act(world, Travel)
        p = world.tables["cart"][Position]
        assert [[float(p.x[i]), float(p.y[i])] for i in range(2)] == places


def test_a_path_is_gone_along_and_around_by_its_length():
    world = World.from_config(
        _yard(
            at=[[2.0, 2.0]],
            size=(40.0, 40.0),
            edges="walls",
            motion={"path": [[5.0, 2.0], [5.0, 6.0], [2.0, 6.0]], "speed": 2.5},
        )
    )
    places = []
    for _ in range(5):
        act(world, Travel)
        places.append([float(getattr(world.tables["cart"][Position], a)[0]) for a in "xy"])
    assert places == [[4.5, 2], [5, 4], [4.5, 6], [2, 6], [pytest.approx(3.5), pytest.approx(4)]]
    assert world.tables["cart"][Route].leg[0] == 0


def test_a_short_path_is_gone_around_within_a_tick():
    world = World.from_config(_yard(at=[[5.0, 5.0]], motion={"path": [[5.0, 5.0], [6.0, 5.0]], "speed": 4.5}))
    act(world, Travel)
    assert _place(world) == [5.5, 5.0]


def test_water_carries_objects_as_it_carries_all():
    config = _yard(at=[[2.0, 2.0, 3.0]], size=(20.0, 10.0, 5.0), body={"sinking": 0.5})
    config["water"] = {"current": [{"depth": 0.0, "velocity": [1.5, 0.0]}]}
    world = World.from_config(config)
    act(world, Drift)
    assert _place(world) == [3.5, 2.0]
    assert world.tables["cart"][Position].z[0] == 2.5


@pytest.mark.parametrize(("pushed", "cart", "ox"), [(True, 5.25, 3.75), (False, 5.0, 3.5)])
def test_what_can_be_pushed_gives_way_by_half_and_else_not_at_all(pushed, cart, ox):
    from ecs_eco.systems import Collide

    world = World.from_config(_yard(at=[[5.0, 5.0]], body={"solid": True, "radius": 1.0}, pushed=pushed))
    arrange(world, "ox", x=4.0, y=5.0)  # half a metre of the radii 1 and 0.5 overlaps
    act(world, Collide)
    assert [cart, 5.0] == _place(world)
    assert [ox, 5.0] == _place(world, "ox")


def test_what_is_still_has_no_such_system():
    world = World.from_config(_yard())
    assert not [s for s in world.systems if isinstance(s, Travel)]
    before = world.tables["cart"][Position].x.copy()
    world.run(3)
    assert np.array_equal(before, world.tables["cart"][Position].x)


@pytest.mark.parametrize(
    ("motion", "fault"),
    [
        ({}, "give either a velocity or a path"),
        (
            {"velocity": [1.0, 0.0], "path": [[1.0, 1.0], [2.0, 2.0]], "speed": 1.0},
            "either a velocity or a path",
        ),
        ({"path": [[1.0, 1.0], [2.0, 2.0]]}, "speed"),
        ({"velocity": [1.0, 0.0], "speed": 1.0}, "given without a path"),
        ({"velocity": [1.0, 0.0, 1.0]}, "wrong number of coordinates"),
        ({"path": [[1.0, 1.0], [30.0, 2.0]], "speed": 1.0}, "outside the world"),
        ({"velocity": [9.0, 0.0]}, "more than half the world's width"),
    ],
)
def test_motion_that_cannot_be_is_refused(motion, fault):
    with pytest.raises(ConfigError, match=fault):
        load(_yard(motion=motion))


def test_what_is_not_solid_is_not_pushed():
    with pytest.raises(ConfigError, match="not solid"):
        load(_yard(pushed=True))
