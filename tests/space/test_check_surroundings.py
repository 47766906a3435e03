"""Fields, ground and ambient values that were written between ticks are refused with the place,
the value and what is allowed."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.space.field import Field
from ecs_eco.space.terrain import Terrain

F = np.float32


@pytest.fixture
def world():
    world = World((10.0, 6.0))
    world.add_table("moss", Position)
    world.spawn("moss")
    world.fields["smell"] = Field(world.space, 1.0)
    world.terrain = Terrain(world.space, 1.0)
    return world.run(1)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_field_holds_finite_numbers(world, value):
    world.fields["smell"].value[0, 2, 3] = value
    with pytest.raises(
        ValueError,
        match=rf"field 'smell': value is {value} in cell \(0, 2, 3\); "
        r"expected: finite numbers",
    ):
        world.run(1)
    assert world.tick == 1
    world.fields["smell"].value[0, 2, 3] = 3e38
    assert world.run(1).tick == 2


@pytest.mark.parametrize("part", ["value", "source"])
@pytest.mark.parametrize(
    "array", [np.zeros((1, 6, 11), F), np.zeros((1, 6, 10)), np.zeros((1, 6, 20), F)[:, :, ::2], 5.0]
)
def test_a_field_is_not_replaced_by_one_of_another_form(world, part, array):
    setattr(world.fields["smell"], part, array)
    with pytest.raises(
        ValueError, match=rf"field 'smell': {part} is .*; expected: float32\[1, 6, 10\] without gaps"
    ):
        world.run(1)


def test_heights_are_finite_and_ground_is_of_a_kind_that_there_is(world):
    world.terrain.height[5, 9] = np.nan
    with pytest.raises(
        ValueError, match=r"terrain: height is nan in cell \(5, 9\); expected: finite numbers \[m\]"
    ):
        world.run(1)
    world.terrain.height[5, 9] = 0
    world.terrain.ground[1, 0] = 4
    with pytest.raises(
        ValueError,
        match=r"terrain: ground is 4 in cell \(1, 0\); expected: 0 open, "
        r"1 water, 2 rock, 3 fence",
    ):
        world.run(1)
    world.terrain.ground = np.zeros((3, 3), np.uint8)
    with pytest.raises(ValueError, match=r"terrain: ground is uint8\[3, 3\]; expected: uint8\[6, 10\]"):
        world.run(1)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300, "warm", None])
def test_ambient_values_are_finite_numbers(world, value):
    world.ambient["temperature"] = value
    with pytest.raises(ValueError, match=r"ambient\['temperature'\] is .*; expected: finite numbers"):
        world.run(1)


def test_an_ambient_value_that_is_missing_is_named(world):
    del world.ambient["light"]
    with pytest.raises(ValueError, match="ambient has no 'light'; it needs temperature, pressure, light"):
        world.run(1)
    world.ambient |= {"light": F(0.5), "salinity": 35}
    assert world.run(1).tick == 2
