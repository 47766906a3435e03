import numpy as np
import pytest

from ecs_eco.components import Metabolism
from ecs_eco.systems import Grow, Shade
from ecs_eco.testing import act, arrange


def test_plants_below_others_grow_less(meadow):
    water = {"attenuation": 0.1, "shading": {"grass": 40.0}, "layer": 2.0}
    changes = {"space": {"size": [20.0, 20.0, 10.0]}, "water": water, "ambient": {"light": 0.5}}
    world = meadow(
        world=changes
        | {"species": {"grass": {"count": 3, "metabolism": {"energy": 0.0, "photosynthesis": 0.4}}}}
    )
    # one in the layers from the top: first, third, last
    table = arrange(world, "grass", z=[9.999999, 5.0, 0.0])
    act(world, Shade)
    act(world, Grow)
    # of the water; then of those above, half of the own layer's included
    depth = np.array([0.0, 0.5 + 0.1 + 0.05, 1.0 + 0.3])
    assert world.environment.water.optical[-1] == pytest.approx(1.3)
    expected = 0.5 * 0.4 * np.exp(-np.array([0.0, 0.5 + 0.1 + 0.05, depth[2]]))
    assert table[Metabolism].energy[table.by_uid()] == pytest.approx(expected, rel=1e-5)


def test_the_light_of_the_world_follows_sun_and_depth(meadow):
    world = meadow(
        world={
            "space": {"size": [20.0, 20.0, 10.0]},
            "water": {"attenuation": 0.2},
            "sun": {"day": 240.0, "start": 0.5},
        }
    )
    at = np.zeros(2, np.float32)
    light = world.surroundings("light", at, at, np.array([10.0, 5.0], np.float32))
    assert light == pytest.approx([1.0, np.exp(-1.0)], rel=1e-6)
    world.tick = 40
    assert world.surroundings("light", at, at, np.array([10.0, 5.0], np.float32)) == pytest.approx(
        light * 0.5, rel=1e-6
    )
    assert world.surroundings("pressure", at, at, np.array([10.0, 0.0], np.float32)) == pytest.approx(
        [101_325, 101_325 + 100_552.5]
    )


def test_a_sun_shines_on_land_too(meadow):
    world = meadow(world={"sun": {"day": 100.0}, "ambient": {"light": 2.0}})
    at = np.zeros(1, np.float32)
    assert world.surroundings("light", at, at, at).tolist() == [0.0]
    world.tick = 50
    assert world.surroundings("light", at, at, at).tolist() == [2.0]
