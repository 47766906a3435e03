"""What studies of predator and prey read of a world is what is in it."""

import numpy as np

from ecs_eco import World
from ecs_eco.config import load
from studies.common.predator_prey import SPECIES, first_extinction, numbers


def test_numbers_are_of_the_species_that_they_are_called_after():
    few = {"species.grass.count": 200, "species.deer.count": 40, "species.wolf.count": 5}
    world = World.from_config(load("predator-prey", few), seed=1, policies="random", learn=False)
    for tick in range(1, 6):
        world.run(1)
        assert numbers(world)[-1].tolist() == [world.tables[name].n for name in SPECIES]
        assert len(numbers(world)) == tick


def test_the_first_extinction_is_of_deer_or_wolves():
    n = np.array([[0, 5, 5], [0, 5, 0], [0, 0, 0]])
    assert first_extinction(n) == (1, "wolf")
    assert first_extinction(n[:1]) == (1, None)
