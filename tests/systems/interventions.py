"""Small savannas with interventions, for tests of them."""

from ecs_eco import World
from ecs_eco.config import load

SMALL = {
    "space.size": [60.0, 60.0],
    "species.grass.count": 250,
    "species.deer.count": 60,
    "species.wolf.count": 21,
    "species.deer.reproduction.energy_min": 0.4,
    "species.deer.policy.learn": False,
    "species.wolf.policy.learn": False,
}


def small(*interventions, **more):
    return load("predator-prey", SMALL | more | {"interventions": list(interventions)})


def world(*interventions, **more):
    return World.from_config(small(*interventions, **more), policies="untrained", seed=4)


def uids(table):
    return set(table.uid[table.rows()].tolist())
