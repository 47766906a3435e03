"""Places of eyes and of the inner sense on the body, and fields of view of one's own, counted by hand."""

import math

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Traits
from ecs_eco.systems import Sense
from ecs_eco.testing import act, arrange


def sea(sensors, size=(20.0, 20.0), genes=(), hares=2, **more):
    """A snail of radius 1 m among hares; walls, so that nothing wraps around."""
    snail = {"count": 2, "body": {"radius": 1.0, "opaque": False}, "sensors": sensors} | more
    if genes:
        snail["genome"] = {"alphabet": "01", "genes": list(genes)}
    return World.from_config(
        {
            "format": 1,
            "name": "garden",
            "space": {"size": list(size), "edges": "walls"},
            "species": {"snail": snail, "hare": {"count": hares, "body": {"radius": 0.25}}},
        },
        policies="random",
    )


def read(world, **places):
    """What the first snail reads, at (10, 10), with its head to the north."""
    up = {"z": 5.0} if world.space.volume else {}
    arrange(world, "snail", x=[10, 2], y=[10, 18], heading=math.pi / 2, **up)
    arrange(world, "hare", **({"x": [10.0, 8.5], "y": [14.0, 10.0]} | up | places))
    act(world, Sense)
    nerves, table = world.tables["snail"].species.nerves, world.tables["snail"]
    first = table.uid[nerves.rows].argmin()
    return dict(zip(nerves.channels, nerves.x[first].tolist(), strict=True))


EYES = [
    {"kind": "nearest", "name": "middle", "target": "hare", "range": 5.0},
    {"kind": "nearest", "name": "front", "target": "hare", "range": 5.0, "at": [2.0, 0.0]},
]


@pytest.mark.definition("3 sensor place")
def test_from_an_eye_at_the_front_another_is_nearest():
    # hares 4 m ahead and 1.5 m to the left; the eye is 2 m ahead of the centre: 2 m and √(2² + 1.5²) = 2.5 m
    seen = read(sea(EYES))
    assert seen["middle_near"] == pytest.approx(1 - 1.5 / 5)
    assert (seen["middle_forward"], seen["middle_left"]) == pytest.approx((0, 1), abs=1e-6)
    assert seen["front_near"] == pytest.approx(1 - 2 / 5)
    assert (seen["front_forward"], seen["front_left"]) == pytest.approx((1, 0), abs=1e-6)


def test_a_view_and_bodies_between_are_those_from_the_eye():
    narrow = EYES[1] | {"fov": 1.0, "name": "narrow", "at": [2.0, 1.5]}
    hidden = EYES[1] | {"occlusion": True, "name": "hidden", "at": [-2.0, 0.0]}
    seen = read(sea([narrow, hidden]), x=[10.0, 10.0], y=[13.0, 14.0])
    # √(1.5² + 1²) = 1.8 m away, 56° to the right; √(1.5² + 2²) = 2.5 m, 37°: both outside of ± 28.6°
    assert seen["narrow_near"] == 0
    # of the two in a row ahead only the nearer is seen, 5 m away from behind the body
    assert seen["hidden_near"] == 0
    seen = read(sea([narrow, hidden]), x=[8.5, 10.0], y=[14.0, 10.5])
    assert seen["narrow_near"] == pytest.approx(1 - 2 / 5)
    assert seen["hidden_near"] == pytest.approx(1 - 2.5 / 5)


def test_an_eye_on_top_of_the_body_is_nearer_to_what_is_above():
    top = EYES[1] | {"at": [0.0, 0.0, 1.0], "name": "top"}
    seen = read(sea([EYES[0], top], (20.0, 20.0, 20.0)), x=10.0, y=10.0, z=[8.0, 1.5])
    assert seen["middle_near"] == pytest.approx(1 - 3 / 5)
    assert (seen["top_near"], seen["top_up"]) == pytest.approx((1 - 2 / 5, 1))


@pytest.mark.definition("3 sensor place")
def test_the_pressure_in_a_soft_body_is_felt_at_the_depth_of_the_place():
    sensors = [
        {"kind": "own", "property": "pressure", "name": name, "at": [0.0, 0.0, up], "scale": 1000.0}
        for name, up in (("crown", 1.0), ("middle", 0.0), ("foot", -1.0))
    ]
    for soft in (True, False):
        world = sea(
            sensors,
            (20.0, 20.0, 20.0),
            properties={"pressure": 101325.0},
            body={"radius": 1.0, "opaque": False, "compressible": soft},
        )
        world.environment.functions = {}
        world.surroundings = lambda quantity, x, y, z: (100000 + 10000 * (20 - z)).astype(np.float32)
        arrange(world, "snail", pressure=250000.0)
        felt = read(world)
        assert felt["middle"] == pytest.approx(250)
        assert (felt["crown"], felt["foot"]) == pytest.approx((240, 260) if soft else (250, 250))


def test_each_sees_over_a_field_of_view_of_its_own():
    eye = {"kind": "nearest", "name": "eye", "target": "hare", "range": 5.0, "fov": 1.0}
    rays = {
        "kind": "rays",
        "name": "ray",
        "targets": ["hare"],
        "count": 1,
        "range": 5.0,
        "angle": 0.0,
        "report": "per_ray",
    }
    genes = [
        {"name": "view", "letters": 1, "trait": "sensors.eye.fov", "values": [1.0, 4.0]},
        {"name": "gaze", "letters": 1, "trait": "sensors.ray.angle", "values": [0.0, math.pi / 2]},
    ]
    world = sea([eye, rays], genes=genes)
    table = world.tables["snail"]
    table[Traits].value[table.by_uid()[0]] = 1.0, 0.0
    seen = read(world)  # ahead 4 m away, to the left 1.5 m
    assert seen["eye_near"] == pytest.approx(1 - 4 / 5)
    assert seen["ray_hare_1"] == pytest.approx(1 - 3.75 / 5)
    table[Traits].value[table.by_uid()[0]] = 4.0, math.pi / 2
    seen = read(world)
    assert seen["eye_near"] == pytest.approx(1 - 1.5 / 5)
    assert seen["ray_hare_1"] == pytest.approx(1 - 1.25 / 5)


@pytest.mark.parametrize("threads", [1, 2])
def test_from_places_on_a_torus_the_nearest_are_those_of_brute_force(threads):
    rng = np.random.default_rng(threads)
    world = World.from_config(
        {
            "format": 1,
            "name": "ring",
            "space": {"size": [20.0, 15.0], "edges": "torus"},
            "species": {
                "snail": {"count": 50, "body": {"radius": 1.0}, "sensors": [EYES[1] | {"at": [1.5, -1.0]}]},
                "hare": {"count": 40, "body": {"radius": 0.25}},
            },
        },
        policies="random",
        threads=threads,
    )
    drawn = {
        name: (rng.random((n, 2)) * (20, 15)).astype(np.float32) for name, n in (("snail", 50), ("hare", 40))
    }
    heading = (rng.random(50) * 6.28).astype(np.float32)
    for name, place in drawn.items():
        arrange(world, name, x=place[:, 0], y=place[:, 1])
    table = arrange(world, "snail", heading=heading)
    act(world, Sense)
    nerves = table.species.nerves
    near = nerves.x[np.argsort(table.uid[nerves.rows]), -1]
    cos, sin = np.cos(heading), np.sin(heading)
    eye = drawn["snail"] + np.stack([1.5 * cos + sin, 1.5 * sin - cos], 1)
    way = drawn["hare"][None] - eye[:, None]
    way -= np.round(way / (20, 15)) * (20, 15)
    assert near == pytest.approx(np.maximum(1 - np.hypot(*way.transpose(2, 0, 1)).min(1) / 5, 0), abs=1e-5)
    assert near.std() > 0.1
