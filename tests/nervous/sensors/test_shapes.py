"""What is seen and felt of capsules and boxes, and with them: counted by hand, and as of spheres where they
are spheres."""

import math

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.systems import Sense
from ecs_eco.testing import act, arrange, check_system

EYES = [
    {
        "kind": "rays",
        "name": "eye",
        "count": 1,
        "range": 5.0,
        "targets": ["post", "wall", "hare"],
        "report": "per_ray",
    },
    {"kind": "nearest", "target": "hare", "range": 8.0, "occlusion": True},
    {"kind": "nearest", "target": "post", "range": 8.0, "name": "to_post"},
    {"kind": "touch", "target": "post", "at": [-0.8, 0.8]},
    {"kind": "touch", "target": "wall", "name": "edge"},
    {"kind": "own", "property": "volume"},
]
BOX = {"shape": "box", "size": [4.0, 1.0, 1.0]}


def _world(post=BOX, *, edges="walls", size=(20.0, 20.0), posts=1, hares=1, snail=None, sensors=EYES, **more):
    return World.from_config(
        {
            "format": 1,
            "name": "garden",
            "space": {"size": list(size), "edges": edges},
            "objects": {"post": {"count": posts, "body": post}},
            "species": {
                "snail": {"count": 1, "body": snail or {"radius": 0.5}, "sensors": sensors} | more,
                "hare": {"count": hares, "body": {"radius": 0.25}},
            },
        },
        policies="random",
    )


def _read(world, *, post, hare=((1.0, 1.0),), x=10.0, y=10.0, heading=0.0, turned=0.0):
    arrange(world, "snail", x=x, y=y, heading=heading)
    for name, places in (("post", post), ("hare", hare)):
        arrange(world, name, **dict(zip("xyz", map(list, zip(*places, strict=True)), strict=False)))
    arrange(world, "post", heading=turned)
    act(world, Sense)
    nerves = world.tables["snail"].species.nerves
    return dict(zip(nerves.channels, nerves.x[0].tolist(), strict=True))


@pytest.mark.definition("1 conformation")
def test_rays_meet_a_box_at_its_side_and_a_capsule_at_its_tip():
    assert _read(_world(), post=[(15, 10)])["eye_post_1"] == pytest.approx(1 - 3 / 5)
    turned = math.pi / 2
    assert _read(_world(), post=[(14, 11)], turned=turned)["eye_post_1"] == pytest.approx(1 - 3.5 / 5)
    assert _read(_world(), post=[(14, 12.1)], turned=turned)["eye_post_1"] == 0
    capsule = {"shape": "capsule", "radius": 0.5, "length": 4.0}
    assert _read(_world(capsule), post=[(15, 10)])["eye_post_1"] == pytest.approx(1 - 3 / 5)
    # past its round tip, where a box would be met
    assert _read(_world(capsule), post=[(14, 11.99)], turned=turned)["eye_post_1"] == pytest.approx(
        1 - (4 - math.sqrt(0.25 - 0.49**2)) / 5, abs=1e-4
    )


@pytest.mark.definition("1 conformation")
def test_an_opaque_box_hides_what_is_behind_it_and_a_road_does_not():
    behind, beside = [(14.0, 10.0)], [(10.0, 14.0)]
    wall = [(12.0, 10.0)]
    for body, seen in ((BOX, False), (BOX | {"opaque": False}, True)):
        read = _read(_world(body), post=wall, hare=behind, turned=math.pi / 2)
        assert (read["hare_near"] > 0) == seen
        # a ray reports what it was asked for, opaque or not
        assert (read["eye_hare_1"], read["eye_post_1"]) == (0, pytest.approx(1 - 1.5 / 5))
    assert _read(_world(), post=wall, hare=beside, turned=math.pi / 2)["hare_near"] == pytest.approx(0.5)
    # from behind it the nearest is hidden, a farther one is seen
    read = _read(_world(hares=2), post=wall, hare=[*behind, (10.0, 15.0)], turned=math.pi / 2)
    assert (read["hare_left"], read["hare_near"]) == pytest.approx((1, 1 - 5 / 8))


@pytest.mark.definition("1 conformation")
def test_the_nearest_of_a_box_is_its_nearest_place_and_of_a_capsule_that_of_its_axis():
    read = _read(_world(), post=[(14, 13)])  # from x = 12, y = 12.5 on
    assert read["to_post_near"] == pytest.approx(1 - math.hypot(2, 2.5) / 8)
    assert read["to_post_forward"] == pytest.approx(2 / math.hypot(2, 2.5))
    capsule = {"shape": "capsule", "radius": 0.5, "length": 4.0}
    read = _read(_world(capsule), post=[(11, 13)])  # its axis from 9.5 to 12.5
    assert (read["to_post_left"], read["to_post_near"]) == pytest.approx((1, 1 - 3 / 8))


@pytest.mark.definition("1 conformation")
def test_what_touches_is_felt_where_it_touches():
    assert _read(_world(), post=[(12.45, 10)])["touch_post"] == 1
    assert _read(_world(), post=[(12.55, 10)])["touch_post"] == 0  # 0.05 m away
    assert _read(_world(), post=[(10, 10.95)])["touch_post"] == 0  # at its side
    long = {"shape": "capsule", "radius": 0.5, "length": 4.0}
    assert _read(_world(snail=long), post=[(13.9, 10)])["touch_post"] == 1  # with its nose
    assert _read(_world(snail=long), post=[(8, 10.9)])["touch_post"] == 0
    assert _read(_world(snail=long), post=[(10, 10)], x=1.9)["edge"] == 1
    assert _read(_world(snail=long), post=[(10, 10)], x=1.9, heading=math.pi / 2)["edge"] == 0


@pytest.mark.definition("1 conformation")
def test_across_the_seam_and_along_the_whole_of_a_long_box():
    long = {"shape": "box", "size": [19.0, 0.2]}
    world = _world(long, edges="torus")
    # it ends at 19.5 and is met there, from the other side
    assert _read(world, post=[(10, 10)], x=2.0, y=10, heading=math.pi)["eye_post_1"] == pytest.approx(1)
    assert _read(world, post=[(10, 12)], x=1.5, y=10)["to_post_near"] == pytest.approx(1 - 1.9 / 8)
    read = _read(world, post=[(10, 10)], x=0.2, y=10, heading=math.pi)
    assert read["eye_post_1"] == pytest.approx(1 - 0.7 / 5)
    assert _read(world, post=[(10, 10)], hare=[(1, 11)], x=1, y=9)["hare_near"] == 0


def test_in_a_volume_a_low_box_hides_only_what_is_low():
    world = _world({"shape": "box", "size": [4.0, 1.0, 2.0]}, size=(20.0, 20.0, 10.0), hares=1)
    for z, seen in ((1.5, False), (4.0, True)):
        arrange(world, "snail", x=10, y=10, z=z, heading=0)
        read = _read(world, post=[(12.0, 10.0, 1.0)], hare=[(14.0, 10.0, z)], turned=math.pi / 2)
        assert (read["hare_near"] > 0) == seen


@pytest.mark.definition("1 conformation")
def test_volume_and_places_of_sensors_are_those_of_the_shape():
    long = {"shape": "capsule", "radius": 0.5, "length": 4.0}
    sensors = [
        {"kind": "own", "property": "volume"},
        {
            "kind": "rays",
            "name": "eye",
            "count": 1,
            "range": 5.0,
            "targets": ["post"],
            "report": "per_ray",
            "at": [1.0, 0.0],
        },
    ]
    read = _read(_world({"radius": 0.5}, snail=long, sensors=sensors), post=[(15, 10)])
    assert read["volume"] == pytest.approx(math.pi * (0.25 * 3 + 0.5**3 * 4 / 3))
    assert read["eye_post_1"] == pytest.approx(1 - 2.5 / 5)  # from its tip, 2 m ahead of its middle


def _crowd(shape, edges, size, threads=1):
    eyes = [
        {
            "kind": "rays",
            "name": "eye",
            "count": 7,
            "fov": 6.2,
            "range": 4.0,
            "targets": ["post", "wall", "hare"],
            "report": "per_ray",
        },
        {"kind": "nearest", "target": "hare", "range": 4.0, "occlusion": True},
        {"kind": "nearest", "target": "post", "range": 4.0, "occlusion": True, "fov": 3.0},
        {"kind": "touch", "target": "any", "at": [-2.0, 1.0]},
    ]
    body = {"radius": 0.5} | ({"shape": "capsule", "length": 1.0} if shape else {})
    small = {"radius": 0.25} | ({"shape": "capsule", "length": 0.5} if shape else {})
    return World.from_config(
        {
            "format": 1,
            "name": "crowd",
            "space": {"size": list(size), "edges": edges},
            "objects": {"post": {"count": 20, "body": body}},
            "species": {
                "snail": {"count": 40, "body": body, "sensors": eyes},
                "hare": {"count": 25, "body": small},
            },
        },
        policies="random",
        threads=threads,
    )


def _apart(world):
    """Put all bodies at random places where none overlaps another."""
    cells = [int(side / 1.25) for side in world.space.size]
    rng = np.random.default_rng(4)
    order, first = rng.permutation(math.prod(cells)), 0
    for name in ("post", "snail", "hare"):
        at = np.stack(np.unravel_index(order[first : first + world.tables[name].n], cells), 1) * 1.25 + 0.6
        first += len(at)
        at += rng.uniform(-0.1, 0.1, at.shape)
        arrange(world, name, **dict(zip("xyz", at.T, strict=False)))
    return world


@pytest.mark.parametrize(
    ("edges", "size"), [("torus", (14.0, 11.0)), ("walls", (14.0, 11.0)), ("torus", (12.0, 9.0, 5.0))]
)
def test_capsules_as_long_as_wide_are_seen_and_felt_as_spheres_are(edges, size):
    read = []
    for shape in (False, True):
        world = _apart(_crowd(shape, edges, size))
        act(world, Sense)
        nerves, table = world.tables["snail"].species.nerves, world.tables["snail"]
        read.append(nerves.x[np.argsort(table.uid[world.index(table).rows])])
    differ = abs(read[0] - read[1]).max(axis=1) > 1e-3
    assert differ.mean() < 0.04  # what is grazed may be met or missed
    assert (read[0] != 0).any(axis=0).sum() > 15


def test_the_system_conforms_with_shapes():
    check_system(Sense, lambda threads: _crowd(True, "torus", (14.0, 11.0), threads))
