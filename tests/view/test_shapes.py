"""Capsules and boxes in the viewer, in recordings and in pictures."""

import math

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Body, Position
from ecs_eco.record import run_to_folder
from ecs_eco.view.inspect import state_of
from ecs_eco.view.live import Live
from ecs_eco.view.paint import Painter, outlines
from ecs_eco.view.replay import Replay

YARD = {
    "format": 1,
    "name": "yard",
    "space": {"size": [20.0, 20.0], "edges": "walls"},
    "objects": {
        "fence": {
            "between": [[2.0, 4.0, 18.0, 4.0], [2.0, 6.0, 2.0, 16.0]],
            "color": "#aa3377",
            "body": {"shape": "box", "size": [1.0, 1.0, 2.0], "solid": True},
        },
        "log": {
            "at": [[10.0, 10.0]],
            "heading": [0.5],
            "color": "#117733",
            "body": {"shape": "capsule", "radius": 0.5, "length": 6.0},
        },
        "stone": {"at": [[15.0, 15.0]], "body": {"radius": 1.0}},
    },
    "species": {
        "eel": {
            "count": 2,
            "color": "#4477aa",
            "look": "worm",
            "body": {"shape": "capsule", "radius": 0.5, "length": 5.0},
            "locomotion": {"speed": {"rest": 0.0}},
            "actions": {"speed": ["rest"]},
            "always_on": ["rest"],
        }
    },
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("yard") / "run"
    run_to_folder(YARD, seed=1, out=out, ticks=4, policies="random", report=False, snapshot_every=2)
    return out


def _kinds(hello):
    return {kind["name"]: kind for kind in [*hello["species"], *hello["objects"]]}


@pytest.mark.definition("1 conformation")
def test_the_page_is_told_shapes_and_sizes():
    world = World.from_config(YARD, seed=1, policies="random")
    kinds = _kinds(Live(world).hello())
    assert (kinds["eel"]["shape"], kinds["eel"]["size"], kinds["eel"]["look"]) == (
        "capsule",
        [5, 1, 1],
        "worm",
    )
    assert (kinds["fence"]["shape"], kinds["log"]["size"]) == ("box", [6, 1, 1])
    fence = world.tables["fence"]
    long, short = fence.uid[fence.by_uid()].tolist()
    assert kinds["fence"]["sizes"] == {str(long): [16, 1, 2], str(short): [10, 1, 2]}
    assert "sizes" not in kinds["log"]
    alone = {**YARD, "objects": {"fence": {**YARD["objects"]["fence"], "between": [[9.0, 10.0, 11.0, 10.0]]}}}
    short = _kinds(Live(World.from_config(alone, seed=1, policies="random")).hello())["fence"]
    assert (short["size"], *short["sizes"].values()) == ([1, 1, 2], [2, 1, 2])
    assert "shape" not in kinds["stone"]
    eel = world.tables["eel"]
    assert state_of(world, int(eel.uid[eel.rows()[0]]))["size"] == pytest.approx([5, 1, 1])


def test_of_a_recorded_run_too_with_the_headings_of_objects(folder):
    replay = Replay(folder)
    kinds = _kinds(replay.hello())
    assert (kinds["eel"]["shape"], kinds["log"]["size"]) == ("capsule", [6, 1, 1])
    assert [kinds["eel"]["look"], "look" in kinds["stone"]] == ["worm", False]
    assert list(kinds["fence"]["sizes"].values()) == [pytest.approx([16, 1, 2]), pytest.approx([10, 1, 2])]
    assert replay.recording.objects["fence"][:, 3] == pytest.approx([0, math.pi / 2])
    assert replay.recording.objects["log"][0, 3:] == pytest.approx([0.5, 6, 1, 1])
    assert replay.recording.objects["stone"][:, 3:].tolist() == [[0, 0, 0, 0]]
    replay.frame(1, "species")


def test_outlines_are_those_of_the_bodies():
    at, turned = np.array([[10.0, 5.0]]), np.array([math.pi / 2])
    box = outlines("box", at, turned, [np.array([4.0]), np.array([2.0]), np.array([1.0])])[0]
    assert (box.min(axis=0), box.max(axis=0)) == (pytest.approx([9, 3]), pytest.approx([11, 7]))
    capsule = outlines("capsule", at, turned, [np.array([4.0]), np.array([2.0]), np.array([2.0])])[0]
    assert (capsule.min(axis=0), capsule.max(axis=0)) == (pytest.approx([9, 3]), pytest.approx([11, 7]))
    assert np.hypot(*(capsule - [10, 6]).T).min() == pytest.approx(1)  # round ends
    side = outlines("box", at, turned, [np.array([4.0]), np.array([2.0]), np.array([1.0])], side=True)[0]
    assert (side.min(axis=0), side.max(axis=0)) == (pytest.approx([9, 4.5]), pytest.approx([11, 5.5]))


def test_pictures_show_them_as_large_as_they_are(folder):
    painter = Painter(Replay(folder), (640, 360))
    picture = painter.paint(2).astype(int)
    painter.ax.figure.canvas.draw()
    box = painter.ax.get_window_extent()

    def pixel(x, y):
        left, bottom = painter.ax.transData.transform((x, y))
        return picture[round(picture.shape[0] - bottom), round(left)]

    assert box.width > 100
    open_ground, fence, wall = pixel(10, 18), pixel(17, 4), pixel(2, 15)
    assert abs(fence - open_ground).max() > 60
    assert abs(wall - open_ground).max() > 60
    assert abs(pixel(2, 2) - open_ground).max() < 10  # no disc around the fences
    log = pixel(10 + 2.3 * math.cos(0.5), 10 + 2.3 * math.sin(0.5))
    assert abs(log - open_ground).max() > 60


def test_bodies_of_recorded_worlds_have_their_sizes(folder):
    world = World.restore(sorted((folder / "checkpoints").glob("tick-*"))[0])
    fence = world.tables["fence"]
    rows = fence.by_uid()
    assert fence[Body].radius[rows] == pytest.approx([math.hypot(16, 1, 2) / 2, math.hypot(10, 1, 2) / 2])
    assert fence[Position].x[rows].tolist() == [10, 2]


def test_who_lies_still_is_no_plant_unless_it_grows_breeds_or_is_eaten():
    kinds = {
        name: {
            kind["name"]: kind["sessile"]
            for kind in Live(World.from_config(name, seed=1, policies="random", record=False)).hello()[
                "species"
            ]
        }
        for name in ("lamb", "predator-prey", "diel-migration")
    }
    assert kinds == {
        "lamb": {"ewe": False, "lamb": False},
        "predator-prey": {"grass": True, "deer": False, "wolf": False},
        "diel-migration": {"phytoplankton": True, "copepod": False, "krill": False},
    }
