"""Following animals: hand-made worlds, and a recorded one."""

from pathlib import Path

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.analysis.escapes import recorded_tracks
from ecs_eco.config import load
from ecs_eco.record import run_to_folder
from ecs_eco.testing import arrange
from studies.common.follow import follow

SMALL = {
    "species.phytoplankton.count": 60,
    "species.copepod.count": 25,
    "species.krill.count": 12,
    "space.size": [16.0, 16.0, 16.0],
    "sun.day": 48.0,
}


def test_tracks_tell_depth_speed_and_the_way_from_the_predator(meadow):
    wolf = {"count": 1, "body": {"radius": 0.1}}
    sea = {"size": [20.0, 20.0, 10.0]}
    world = meadow(
        world={"space": sea, "species": {"wolf": wolf}},
        count=2,
        reflex={"formulas": {"walk": "1"}},
        lethal=[],
    )
    arrange(world, "deer", x=[1, 5], y=5, z=[4, 9], heading=[0, np.pi / 2])
    arrange(world, "wolf", x=19, y=5, z=4)  # 2 m behind the first, across the edge
    tracks = follow(world, 2, "deer", "wolf", within=5.0)
    assert tracks.depth.tolist() == [[6, 1], [6, 1]]
    assert np.nanmean(tracks.depth, axis=1).tolist() == [3.5, 3.5]
    assert tracks.speed == pytest.approx(np.ones((2, 2)), abs=1e-5)
    assert tracks.distance[:, 0] == pytest.approx([2, 3])
    assert tracks.distance[0, 1] == np.inf
    assert tracks.away[:, 0] == pytest.approx([1, 1], abs=1e-5)
    assert np.isnan(tracks.away[0, 1])
    assert tracks.aside[:, 0] == pytest.approx([0, 0], abs=1e-5)
    assert tracks.light.tolist() == [1, 1]


def test_the_side_of_away_is_on_the_left(meadow):
    wolf = {"count": 1, "body": {"radius": 0.1}}
    sea = {"size": [20.0, 20.0, 10.0]}
    world = meadow(
        world={"space": sea, "species": {"wolf": wolf}},
        count=4,
        reflex={"formulas": {"walk": "1"}},
        lethal=[],
    )
    # all swim north, around a wolf
    arrange(world, "deer", x=[5, 7, 5, 3], y=[7, 5, 3, 5], z=4, heading=np.pi / 2)
    arrange(world, "wolf", x=5, y=5, z=4)
    tracks = follow(world, 1, "deer", "wolf")
    assert tracks.away[0] == pytest.approx([1, 0, -1, 0], abs=1e-5)
    assert tracks.aside[0] == pytest.approx([0, 1, 0, -1], abs=1e-5)


def test_tracks_from_details_are_those_followed_live(tmp_path: Path):
    small = load("diel-migration", SMALL)
    run_to_folder(
        small, seed=4, ticks=25, out=tmp_path / "run", policies="untrained", record="full", report=False
    )
    tracks = recorded_tracks(tmp_path / "run", "copepod", "krill")
    world = World.from_config(small, policies="untrained", seed=4).run(1)
    live = follow(world, 24, "copepod", "krill")
    assert tracks.light == pytest.approx(live.light, abs=1e-6)
    both, i, j = np.intersect1d(tracks.uids, live.uids, return_indices=True)
    assert both.size == live.uids.size
    for name in ("speed", "distance"):
        a, b = getattr(tracks, name)[:-1, i], getattr(live, name)[: len(tracks.light) - 1, j]
        known = np.isfinite(a) & np.isfinite(b)
        assert known.sum() > 50
        assert a[known] == pytest.approx(b[known], abs=1e-4)
