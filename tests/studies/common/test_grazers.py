"""Deer whose decisions are written by hand go to grass, and away from wolves where they are to."""

import numpy as np
import pytest

from ecs_eco import World
from studies.common.grazers import AHEAD, CHANNELS, LEFT, RIGHT, RUN, STILL, WALK, graze, graze_and_flee

UID = np.array([1], np.uint64)


def sensed(**values):
    return np.array([[values.get(name, 0.0) for name in CHANNELS]], np.float32)


def test_channels_are_those_of_the_shipped_deer():
    world = World.from_config("predator-prey", policies="random")
    assert tuple(world.tables["deer"].species.nerves.channels) == CHANNELS


@pytest.mark.parametrize(
    ("seen", "decided"),
    [
        ({"grass_forward": 1.0, "grass_near": 0.5}, [WALK, AHEAD]),
        ({"grass_left": 1.0, "grass_near": 0.5}, [STILL, LEFT]),
        ({"grass_left": -0.8, "grass_forward": 0.6, "grass_near": 0.5}, [WALK, RIGHT]),
        ({"grass_forward": -1.0, "grass_near": 0.5}, [STILL, LEFT]),
        ({}, [WALK, AHEAD]),
        ({"grass_forward": 1.0, "grass_near": 0.5, "energy": 0.9}, [STILL, AHEAD]),
    ],
)
def test_hungry_deer_go_to_the_nearest_grass_and_sated_ones_stand(seen, decided):
    assert graze(sensed(**seen), UID).tolist() == [decided]
    assert graze_and_flee(sensed(**seen), UID).tolist() == [decided]


def test_deer_that_flee_turn_from_a_wolf_and_run():
    seen = sensed(grass_forward=1.0, grass_near=0.5, wolf_left=1.0, wolf_near=0.2)
    assert graze(seen, UID).tolist() == [[WALK, AHEAD]]
    assert graze_and_flee(seen, UID).tolist() == [[RUN, RIGHT]]
    behind = sensed(wolf_forward=-1.0, wolf_near=0.2)
    assert graze_and_flee(behind, UID).tolist() == [[RUN, AHEAD]]
