"""Rays from a place on the body and at an angle, hand-counted; tests/space/test_sight.py has the rest."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Senses
from ecs_eco.systems import Sense
from ecs_eco.testing import act, arrange

EYE = {
    "kind": "rays",
    "name": "eye",
    "count": 1,
    "range": 5.0,
    "targets": ["post", "wall"],
    "report": "per_ray",
}


def _world(*, size=(20.0, 20.0), edges="walls", snail=(), ambient=1.0, **eye):
    snail = {"count": 1, "body": {"radius": 0.5}, "sensors": [EYE | eye]} | dict(snail)
    return World.from_config(
        {
            "format": 1,
            "name": "garden",
            "space": {"size": list(size), "edges": edges},
            "ambient": {"light": ambient},
            "objects": {"post": {"count": 1, "body": {"radius": 1.0}}},
            "species": {"snail": snail},
        },
        policies="random",
    )


def _read(world, post, x=10.0, y=10.0, heading=0.0, **more):
    arrange(world, "snail", x=x, y=y, heading=heading, **more)
    arrange(world, "post", x=post[0], y=post[1], **({"z": post[2]} if len(post) > 2 else {}))
    act(world, Sense)
    nerves = world.tables["snail"].species.nerves
    return dict(zip(nerves.channels, nerves.x[0].tolist(), strict=True))


def test_a_ray_at_an_angle_looks_to_the_left():
    world = _world(angle=np.pi / 2)
    assert _read(world, (10, 14))["eye_post_1"] == pytest.approx(1 - 3 / 5)
    assert _read(world, (14, 10))["eye_post_1"] == 0
    assert _read(world, (14, 10), heading=-np.pi / 2)["eye_post_1"] == pytest.approx(1 - 3 / 5)


def test_the_closest_hit_of_rays_at_an_angle_has_the_direction_from_the_heading():
    world = _world(angle=np.pi / 2, report="closest")
    read = _read(world, (10, 14))
    assert [read[f"eye_post_{way}"] for way in ("forward", "left", "near")] == pytest.approx(
        [0, 1, 0.4], abs=1e-6
    )


@pytest.mark.definition("3 sensor place")
def test_rays_begin_where_the_eye_is_on_the_body():
    world = _world(at=[2.0, 1.0])  # 1 m ahead, 0.5 m to the left
    assert _read(world, (15, 10.5))["eye_post_1"] == pytest.approx(1 - 3 / 5)
    assert _read(world, (15, 11.25))["eye_post_1"] > 0
    assert _read(world, (15, 9.25))["eye_post_1"] == 0
    assert _read(world, (3, 3), x=17)["eye_wall_1"] == pytest.approx(1 - 2 / 5)
    assert _read(world, (10, 15), heading=np.pi / 2)["eye_post_1"] == pytest.approx(
        1 - (4 - np.sqrt(0.75)) / 5, abs=1e-6
    )


def test_an_eye_beyond_the_edge_of_the_torus_looks_on_from_the_other_side():
    world = _world(at=[2.0, 0.0], edges="torus")
    assert _read(world, (3.5, 10), x=19.5)["eye_post_1"] == pytest.approx(1 - 2 / 5)


def test_in_a_volume_the_eye_may_be_above_the_body():
    world = _world(size=(20.0, 20.0, 10.0), at=[0.0, 0.0, 3.0])
    assert _read(world, (14, 10, 6.5), z=5)["eye_post_1"] == pytest.approx(1 - 3 / 5)
    assert _read(world, (14, 10, 5), z=5)["eye_post_1"] == 0


def test_the_place_of_an_eye_may_be_heritable():
    gene = {"name": "stalk", "trait": "sensors.eye.forward", "letters": 2, "low": 0.0, "high": 1e-6}
    world = _world(snail={"genome": {"genes": [gene]}})
    assert _read(world, (15, 10))["eye_post_1"] == pytest.approx(1 - 4 / 5, abs=1e-5)
    world.tables["snail"][Senses].forward[:, 0] = 4
    assert _read(world, (15, 10))["eye_post_1"] == pytest.approx(1 - 2 / 5)


@pytest.mark.parametrize(("light", "reach"), [(1.0, 5.0), (0.5, 4.0), (0.0, 1.5)])
def test_rays_by_light_reach_as_far_as_it_is_light(light, reach):
    world = _world(sight=5.0, blind=1.5, ambient=light)  # at most 5 m
    assert _read(world, (14, 10))["eye_post_1"] == pytest.approx(max(1 - 3 / reach, 0))
    assert _read(world, (12, 10))["eye_post_1"] == pytest.approx(1 - 1 / reach)


def test_who_is_blind_in_the_dark_sees_nothing_there():
    assert _read(_world(sight=5.0, ambient=0.0), (11.2, 10))["eye_post_1"] == 0
