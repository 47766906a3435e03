"""Seekers: for each organism the nearest of another table, found or not."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Body, Position
from ecs_eco.space import Seekers


@pytest.fixture
def world():
    world = World((20.0, 20.0))
    for name, places in {"deer": [(1, 1), (10, 10), (5, 5)], "wolf": [(4, 5), (19, 1)], "bear": []}.items():
        world.add_table(name, Position, Body)
        for x, y in places:
            world.spawn(name, Position(x=float(x), y=float(y), heading=0.5), Body(radius=0.25))
    world.flush()
    return world


def by_uid(world, seekers, values):
    return dict(zip(world.table("deer").uid[seekers.rows].tolist(), values.tolist(), strict=True))


def test_each_has_the_nearest_of_another_table_by_hand(world):
    deer, wolf = world.table("deer"), world.table("wolf")
    seekers = Seekers(world, deer)
    rows, distance = seekers.nearest("wolf", 3.0)
    uids = np.where(rows >= 0, wolf.uid[rows], 0)
    # around the torus the wolf at x = 19 is 2 m from the deer at x = 1
    assert by_uid(world, seekers, uids) == {1: 5, 2: 0, 3: 4}
    assert by_uid(world, seekers, distance) == {1: 2.0, 2: np.inf, 3: 1.0}
    assert (seekers.n, seekers.radius.tolist()) == (3, [0.25] * 3)
    np.testing.assert_array_equal(seekers.cos, np.cos(seekers.heading, dtype=np.float32))


def test_nobody_is_found_in_an_empty_table_and_nobody_is_its_own_neighbor(world):
    seekers = Seekers(world, world.table("deer"))
    rows, distance = seekers.nearest(world.table("bear"), 9.0)
    assert rows.tolist() == [-1] * 3
    assert np.isinf(distance).all()
    rows, distance = seekers.nearest("deer", 9.0)
    assert by_uid(world, seekers, world.table("deer").uid[rows]) == {1: 3, 2: 3, 3: 1}
    none = Seekers(world, world.table("bear")).nearest("deer", 9.0)
    assert [part.size for part in none] == [0, 0]


def test_a_wrong_table_or_radius_is_named(world):
    seekers = Seekers(world, world.table("deer"))
    with pytest.raises(KeyError, match='did you mean "wolf"'):
        seekers.nearest("wulf", 3.0)
    with pytest.raises(ValueError, match="radius"):
        seekers.nearest("wolf", -1.0)
