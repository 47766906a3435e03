"""A property of the bodies around, hand-counted; tests/space/test_sums.py has its kernel's slow twin."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Biology, Body, Senses
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.systems import Sense
from ecs_eco.testing import act, arrange, shuffle

SIDE = 20.0  # [m] of the torus
WOLF = {
    "count": 3,
    "body": {"radius": 0.5, "mass": 40.0},
    "properties": {"temperature": 310.0},
    "substances": {"musk": 0.25},
    "fertility": 0.5,
}
LAMP = {"count": 1, "body": {"radius": 0.25}, "properties": {"luminous_intensity": 8.0}}


def _config(*sensors, size=(SIDE, SIDE), edges="torus", **changes):
    eel = {
        "count": 4,
        "body": {"radius": 1.0, "mass": 2.0},
        "properties": {"electric_current": 3.0},
        "sensors": [{"kind": "property", "range": 4.0, "name": f"s{i}"} | s for i, s in enumerate(sensors)],
    }
    return {
        "format": 1,
        "name": "sea",
        "space": {"size": list(size), "edges": edges},
        "substances": {"musk": "a scent", "salt": "not in bodies"},
        "objects": {"lamp": LAMP},
        "species": {"eel": eel | changes, "wolf": WOLF},
    }


def _read(world):
    """What each eel reads, in the order of uids: [eels, sensors]."""
    act(world, Sense)
    table = world.tables["eel"]
    nerves = table.species.nerves
    return nerves.x[np.argsort(table.uid[nerves.rows])].astype(float)


def _world(*sensors, **changes):
    """Eels at x = 1, 3 and 18 of a torus of 20 m, 2, 3 and 5 m from one another, and one at 10 alone."""
    world = World.from_config(_config(*sensors, **changes), policies="random")
    arrange(world, "eel", x=[1, 3, 18, 10], y=10, heading=0)
    arrange(world, "wolf", x=[10, 1, 19], y=[1, 1, 1])
    arrange(world, "lamp", x=5, y=1)
    return world


@pytest.mark.definition("3 sensor property")
@pytest.mark.parametrize(
    ("decay", "reads"),
    [
        ("none", [6, 3, 3, 0]),
        ("linear", [3 * (0.5 + 0.25), 1.5, 0.75, 0]),
        ("inverse_square", [3 / 4 + 3 / 9, 3 / 4, 3 / 9, 0]),
    ],
)
def test_current_is_summed_over_the_others_in_reach_across_the_edge(decay, reads):
    world = _world({"property": "electric_current", "of": "eel", "decay": decay})
    assert _read(world)[:, 0] == pytest.approx(reads)


def test_a_body_at_the_radius_is_out_of_reach():
    world = _world(
        {"property": "mass", "of": "eel", "range": 2.0}, {"property": "mass", "of": "eel", "range": 2.001}
    )
    assert _read(world)[0] == pytest.approx([0, 2])


def test_the_inverse_square_ends_at_the_surface_of_the_other_body():
    world = _world({"property": "luminous_intensity", "of": "lamp", "decay": "inverse_square"})
    arrange(world, "lamp", x=10, y=10.125)  # 0.125 m off, within its radius of 0.25 m
    assert _read(world)[:, 0] == pytest.approx([0, 0, 0, 8 / 0.25**2])
    arrange(world, "lamp", x=10, y=10.5)
    assert _read(world)[:, 0] == pytest.approx([0, 0, 0, 8 / 0.5**2])  # 32 lx


def test_the_mean_is_weighted_and_zero_where_there_is_nobody():
    world = _world(
        {"property": "age", "of": "eel", "report": "mean"},
        {"property": "age", "of": "eel", "report": "mean", "decay": "linear"},
        {"property": "age", "of": "eel", "report": "mean", "zero": 20.0, "scale": 10.0},
    )
    arrange(world, "eel", age=[0, 30, 60, 90])
    assert _read(world) == pytest.approx(
        np.array([[45, (0.5 * 30 + 0.25 * 60) / 0.75, 2.5], [0, 0, -2], [0, 0, -2], [0, 0, 0]])
    )


def test_zero_is_taken_from_each_body_and_scale_divides_the_sum():
    world = _world({"property": "temperature", "of": "wolf", "zero": 290.0, "scale": 10.0, "decay": "linear"})
    arrange(world, "wolf", x=[1, 19, 10], y=[12, 10, 1], temperature=[310, 300, 310])
    reads = [2 * 0.5 + 1 * 0.5, 2 * (1 - np.sqrt(8) / 4), 2 * (1 - np.sqrt(13) / 4) + 1 * 0.75, 0]
    assert _read(world)[:, 0] == pytest.approx(reads, abs=1e-6)


def test_who_is_not_named_is_everybody_that_has_the_property():
    world = _world(
        {"property": "mass"},
        {"property": "mass", "of": ["eel", "wolf"]},
        {"property": "fertility"},
        {"property": "luminous_intensity"},
        {"property": "musk"},
    )
    arrange(world, "wolf", x=[1, 1, 12], y=[12, 8, 1])
    arrange(world, "lamp", x=1, y=11)
    # the eels at 3 and 18 have masses of 2 kg and a fertility of 1, both wolves 40 kg and 0.5; the lamp 1 kg
    assert _read(world)[0] == pytest.approx([85, 84, 3, 8, 0.5])


@pytest.mark.parametrize(
    ("name", "reads"),
    [
        ("energy", 0.75),
        ("age", 7),
        ("fertility", 0.5),
        ("sex", 2),
        ("mass", 40),
        ("radius", 0.5),
        ("volume", 4 / 3 * np.pi / 8),
        ("temperature", 310),
        ("musk", 0.25),
    ],
)
def test_every_property_of_another_can_be_felt(name, reads):
    world = _world({"property": name, "of": "wolf"})
    arrange(world, "wolf", x=[1, 10, 10], y=[8, 1, 1], energy=0.75, age=7, sex=2)
    assert _read(world)[0, 0] == pytest.approx(reads)


def test_a_sensor_of_the_own_body_feels_its_sex_mass_radius_and_volume():
    names = ("sex", "mass", "radius", "volume")
    world = _world(sensors=[{"kind": "own", "property": name} for name in names])
    assert world.tables["eel"].species.nerves.channels == names
    arrange(world, "eel", sex=1)
    assert _read(world)[0] == pytest.approx([1, 2, 1, 4 / 3 * np.pi])


@pytest.mark.definition("3 sensor place")
def test_the_place_of_the_sensor_turns_with_the_body_and_may_lie_beyond_the_edge():
    world = _world({"property": "mass", "of": "wolf", "range": 1.0, "at": [2.0, 1.0], "decay": "linear"})
    arrange(world, "eel", x=[19, 19, 19, 10], y=[10, 10, 10, 5], heading=[0, np.pi / 2, np.pi, 0])
    arrange(world, "wolf", x=[1.25, 17.75, 12], y=[11, 12, 1])
    # two radii of 1 m ahead and one to the left: (21, 11), (18, 12), (17, 9), (12, 6)
    assert _read(world)[:, 0] == pytest.approx([40 * 0.75, 40 * 0.75, 0, 0], abs=1e-4)


def test_between_walls_a_place_beyond_them_is_at_the_wall():
    world = World.from_config(
        _config(
            {"property": "mass", "of": "wolf", "range": 2.0, "at": [2.0, 0.0], "decay": "linear"},
            edges="walls",
        ),
        policies="random",
    )
    arrange(world, "eel", x=19, y=10, heading=0)
    arrange(world, "wolf", x=[19, 1, 10], y=[10, 10, 1])
    assert _read(world)[:, 0] == pytest.approx([20] * 4, abs=1e-3)


def test_in_a_volume_height_counts_and_the_place_may_be_above():
    world = World.from_config(
        _config(
            {"property": "mass", "of": "wolf", "decay": "linear"},
            {"property": "mass", "of": "wolf", "decay": "linear", "at": [0, 0, 1]},
            size=(SIDE, SIDE, 10.0),
        ),
        policies="random",
    )
    arrange(world, "eel", x=[1, 10, 10, 10], y=10, z=5)
    arrange(world, "wolf", x=[19, 5, 5], y=[10, 1, 1], z=[7, 5, 5])
    far = 1 - np.sqrt([8, 5]) / 4
    assert _read(world)[0] == pytest.approx(40 * far, abs=1e-4)


def test_the_dead_and_the_unborn_do_not_count():
    world = _world({"property": "mass", "of": "eel"})
    table = world.tables["eel"]
    world.spawn("eel", Body(mass=100.0))  # asked for, not yet born
    assert _read(world)[0, 0] == pytest.approx(4)
    world.kill(int(table.uid[table.by_uid()[1]]))
    table.births.clear()
    world.flush()
    assert _read(world)[:, 0] == pytest.approx([2, 2, 0])


def test_remains_have_the_properties_of_those_who_died():
    config = _config({"property": "musk"}, {"property": "musk", "of": "bones"})
    config["objects"]["bones"] = {"body": {"radius": 0.1}}
    config["species"]["wolf"] = WOLF | {"remains": "bones"}
    world = World.from_config(config, policies="random")
    arrange(world, "eel", x=1, y=10)
    arrange(world, "wolf", x=[1, 10, 10], y=[8, 1, 1])
    assert _read(world)[0] == pytest.approx([0.25, 0])
    table = world.tables["wolf"]
    world.kill(int(table.uid[table.by_uid()[0]]))
    world.run(1)
    arrange(world, "eel", x=1, y=10)
    assert _read(world)[0] == pytest.approx([0.25, 0.25])


def test_reach_and_place_may_be_heritable():
    genes = [
        {"name": "far", "trait": "sensors.s0.range", "letters": 1, "values": [4.0] * 4},
        {"name": "ahead", "trait": "sensors.s0.forward", "letters": 1, "values": [0.0] * 4},
    ]
    world = _world(
        {"property": "mass", "of": "wolf", "range": 1.0, "decay": "linear"}, genome={"genes": genes}
    )
    arrange(world, "eel", x=10, y=10, heading=0)
    arrange(world, "wolf", x=[14, 1, 1], y=[10, 1, 1])
    table = world.tables["eel"]
    rows = table.by_uid()
    table[Senses].radius[rows, 0] = [4, 8, 4, 2]
    table[Senses].forward[rows, 0] = [0, 0, 2, 2]
    assert _read(world)[:, 0] == pytest.approx([0, 20, 20, 0], abs=1e-4)


def test_what_is_felt_does_not_depend_on_rows_or_threads():
    sensors = [
        {"property": "age", "decay": "inverse_square", "range": 9.0, "at": [1.0, 0.5]},
        {"property": "temperature", "zero": 290.0, "report": "mean", "decay": "linear", "range": 9.0},
        {"property": "electric_current", "decay": "linear", "range": 3.0},
    ]
    readings = []
    for threads, reorder in ((1, False), (2, False), (1, True)):
        config = _config(*sensors, size=(50.0, 40.0), count=3000)
        config["species"]["wolf"] = WOLF | {"count": 2000}
        world = World.from_config(config, policies="random", threads=threads, seed=3)
        for name in ("eel", "wolf"):
            table = world.tables[name]
            table[Biology].age[table.rows()] = np.modf(table.uid[table.rows()] * 0.618)[0] * 100
        if reorder:
            shuffle(world)
        readings.append(_read(world).tobytes())
    assert readings[0] == readings[1] == readings[2]


@pytest.mark.parametrize(
    ("sensor", "path", "allowed", "right"),
    [
        ({"property": "temprature", "of": "wolf"}, "property", "temperature, musk", "temperature"),
        ({"property": "musk", "of": "eel"}, "property", "electric_current", ""),
        ({"property": "energy", "of": "lamp"}, "property", "luminous_intensity, mass, radius, volume", ""),
        ({"property": "salt"}, "property", "temperature, musk", ""),
        ({"property": "elctric_current"}, "property", "electric_current", "electric_current"),
        ({"property": "mass", "of": "wlf"}, "of", "eel, wolf, lamp", "wolf"),
        ({"property": "mass", "of": ["eel", "wlf"]}, "of.1", "eel, wolf, lamp", "wolf"),
        ({"property": "mass", "of": ["eel", "eel"]}, "of.1", "once", ""),
        ({"property": "mass", "of": []}, "of", "at least 1", ""),
        ({"property": "mass", "of": 3}, "of", "text", ""),
        (
            {"property": "mass", "decay": "inverse_sqare"},
            "decay",
            "none, linear, inverse_square",
            "inverse_square",
        ),
        ({"property": "mass", "report": "man"}, "report", "sum, mean", "mean"),
        ({"property": "mass", "range": 10.5}, "range", "at most 10 m", ""),
        ({"property": "mass", "at": [11.0, 0.0]}, "at", "at most 10", ""),
        ({"property": "mass", "at": [0.0, 0.0, 1.0]}, "at", "forward and left", ""),
        ({"property": "mass", "scale": 0.0}, "scale", "more than 0", ""),
    ],
)
def test_what_is_wrong_is_said_with_the_nearest_right_name(sensor, path, allowed, right):
    with pytest.raises(ConfigError) as caught:
        load(_config(sensor))
    (problem,) = caught.value.problems
    assert problem.path == f"species.eel.sensors.0.{path}"
    assert allowed in problem.allowed
    assert problem.nearest == right


def test_channels_are_named_after_whose_property_is_felt():
    sensors = [
        {"property": "mass", "name": None},
        {"property": "mass", "of": "wolf", "name": None},
        {"property": "mass", "of": ["eel", "wolf"], "name": None},
    ]
    assert load(_config(*sensors)).species["eel"].channels(2) == ("any_mass", "wolf_mass", "eel_wolf_mass")
