"""Places for the newborn of few parents, found in one call, are those that indexes of neighbours find."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Body
from ecs_eco.config import load
from ecs_eco.life import broods

DEER = "species.deer.reproduction."
CASES = {
    "anywhere": {DEER + "rate": 0.2},
    "near their parents, in litters, apart, between walls": {
        "space.edges": "walls",
        DEER + "dispersal": 2.0,
        DEER + "place": "near",
        DEER + "spacing": 1.5,
        DEER + "rate": 0.3,
        DEER + "litter": 3,
        DEER + "energy_given": 0.05,
    },
    "where much is in the way": {
        "species.deer.body.radius": 3.0,
        DEER + "rate": 0.5,
        "species.wolf.body.opaque": False,
    },
}


@pytest.mark.parametrize("case", CASES)
def test_all_newborn_are_the_same(case, monkeypatch):
    config, digests, small = load("predator-prey", CASES[case]), [], []

    def seen(*arguments, known=broods.settle):
        small.append(known(*arguments))
        return small[-1]

    monkeypatch.setattr(broods, "settle", seen)
    for most in (broods.MOST_PAIRS, -1):
        monkeypatch.setattr(broods, "MOST_PAIRS", most)
        world = World.from_config(config, seed=1, policies="untrained").run(15)
        digests.append((world.digest(), len(small)))
    assert digests[0] == digests[1]
    assert np.sum(small) > 10


def test_a_newborn_is_placed_nowhere_where_a_body_is_everywhere():
    world = World.from_config(load("predator-prey"), seed=1, policies="untrained")
    world.flush()
    world.tables["wolf"][Body].radius[:] = 1000.0
    table, parents = world.tables["deer"], np.arange(2)
    way, given = table.species.reproduction, np.full(2, 0.1, np.float32)
    brood, born = broods.small_brood(table, world, way, parents, np.array([1, 2]), given, 3)
    assert (brood.which.size, born.tolist()) == (0, [0, 0])
