"""Hills block the view of rays and `nearest`: eyes and tops are at the height of the body."""

import pytest

from ecs_eco import World
from ecs_eco.systems import Sense
from ecs_eco.testing import act, arrange

SIDE = 26.0
SENSORS = [
    {
        "kind": "rays",
        "name": "eye",
        "count": 1,
        "range": 12.0,
        "targets": ["post", "tower"],
        "report": "per_ray",
    },
    {"kind": "nearest", "target": "post", "range": 12.0, "occlusion": True},
    {"kind": "nearest", "target": "tower", "range": 12.0, "occlusion": True},
]


def _read(height, *, hides=True, kind="post", body=None, eye=0.5, edges="walls", shift=0.0):
    """What a snail at x = 5 reads of a post or tower at x = 15, with a hill of a height [m] halfway."""
    place = [(10.0 + shift) % SIDE, 10.0]
    hill = {"at": place, "radius": 3.0, "height": height}
    world = World.from_config(
        {
            "format": 1,
            "name": "garden",
            "space": {"size": [SIDE, SIDE], "edges": edges},
            "terrain": {"cell": 0.25, "mountains": [hill]} | ({"hides": True} if hides else {}),
            "objects": {
                "post": {"count": 1, "body": {"radius": 1.0}},
                "tower": {"count": 1, "body": body or {"shape": "box", "size": [1.0, 1.0, 4.0]}},
            },
            "species": {"snail": {"count": 1, "body": {"radius": eye}, "sensors": SENSORS}},
        },
        policies="random",
    )
    other = "tower" if kind == "post" else "post"
    arrange(world, "snail", x=(5.0 + shift) % SIDE, y=10.0, heading=0.0)
    arrange(world, kind, x=(15.0 + shift) % SIDE, y=10.0)
    arrange(world, other, x=5.0, y=2.0)
    act(world, Sense)
    nerves = world.tables["snail"].species.nerves
    read = dict(zip(nerves.channels, nerves.x[0].tolist(), strict=True))
    ray, near = read[f"eye_{kind}_1"] > 0, read[f"{kind}_forward"] > 0.99
    assert ray == near
    return ray


@pytest.mark.definition("4 space")
@pytest.mark.parametrize(("height", "seen"), [(1.2, True), (1.8, False)])
def test_a_hill_higher_than_the_line_between_the_tops_hides(height, seen):
    assert _read(height) == seen  # from 1 m to 2 m: 1.5 m halfway
    assert _read(height, eye=1.0)  # from 2 m it looks over both


@pytest.mark.parametrize(("height", "seen"), [(2.2, True), (2.8, False)])
def test_a_tower_is_as_high_as_its_box(height, seen):
    assert _read(height, kind="tower") == seen  # from 1 m to 4 m: 2.5 m halfway


def test_hills_hide_nothing_unless_the_world_says_so():
    assert _read(10.0, hides=False)
    assert _read(10.0, hides=False, kind="tower")


@pytest.mark.parametrize("kind", ["post", "tower"])
def test_the_line_of_sight_crosses_the_edge_of_a_torus(kind):
    assert _read(0.5, edges="torus", shift=13.0, kind=kind)
    assert not _read(5.0, edges="torus", shift=13.0, kind=kind)
    assert not _read(5.0, edges="torus", shift=18.0, kind=kind)


def test_a_post_on_the_hill_is_seen_and_one_right_behind_it_is_not():
    world = World.from_config(
        {
            "format": 1,
            "name": "garden",
            "space": {"size": [30.0, 20.0], "edges": "walls"},
            "terrain": {
                "cell": 0.25,
                "hides": True,
                "mountains": [{"at": [10.0, 10.0], "radius": 4.0, "height": 3.0}],
            },
            "objects": {"post": {"count": 2, "body": {"radius": 0.4}}},
            "species": {"snail": {"count": 1, "body": {"radius": 0.5}, "sensors": SENSORS[1:2]}},
        },
        policies="random",
    )
    nerves = world.tables["snail"].species.nerves
    near = nerves.channels.index("post_near")
    arrange(world, "snail", x=3.0, y=10.0)
    for places, distance in (((10.0, 13.0), 7.0), ((13.0, 13.5), None), ((13.0, 9.5), 6.5)):
        arrange(world, "post", x=list(places), y=10.0)
        act(world, Sense)
        expected = 0.0 if distance is None else 1 - distance / 12
        assert nerves.x[0][near] == pytest.approx(expected, abs=1e-6)
