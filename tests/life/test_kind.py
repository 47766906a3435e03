import numpy as np
import pytest

from ecs_eco.components import Position
from ecs_eco.life.births import room
from ecs_eco.life.founders import scatter
from ecs_eco.life.kind import Kind
from ecs_eco.systems.intervene import Region

ALONE = {"kind": "asexual", "rate": 0.5, "energy_min": 0.5, "energy_given": 0.2}


def test_reproduction_is_switched_off_and_on_again_as_the_world_file_says(meadow):
    species = meadow(reproduction=ALONE).tables["deer"].species
    assert species.reproduction.rate == 0.5
    species.barren = True
    assert species.reproduction is None
    species.barren = False
    assert species.reproduction.rate == 0.5


def test_a_kind_made_by_hand_has_nothing_that_happens_to_it():
    species = Kind()
    assert species.parts() == {}
    assert (species.reproduction, species.diet, species.lethal, species.nerves) == (None, [], [], None)


def test_the_room_below_max_count_counts_the_living_and_those_that_wait_to_be_born(meadow):
    world = meadow(count=5, max_count=12, reproduction=ALONE)
    deer = world.tables["deer"]
    assert room(deer, world, 30) == 7
    world.spawn("deer", n=3)
    assert room(deer, world, 30) == 4
    world.spawn("deer", n=9)
    assert room(deer, world, 30) == 0


@pytest.mark.parametrize("numbers", [(10.0, 10.0, 3.0), (2.0, 4.0, 6.0, 12.0)])
def test_newcomers_are_scattered_over_the_region_that_was_asked_for(meadow, numbers):
    world = meadow()
    deer, region = world.tables["deer"], Region(world.space, numbers)
    values = scatter(deer, world, np.arange(1, 401, dtype=np.uint64), region)
    x, y = values[Position, "x"], values[Position, "y"]
    assert region.has(x, y).all()
    assert np.ptp(x) > 3.5
    assert np.ptp(y) > 3.5
