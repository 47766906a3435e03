"""Ten small worlds of many kinds, for tests of what all views of a run must agree on."""

from ecs_eco.config import load
from tests.conftest import MENAGERIE

WORLDS = {
    "predator-prey": {
        "species.grass.count": 300,
        "species.deer.count": 60,
        "species.deer.reproduction.rate": 0.3,
        "species.deer.reproduction.energy_min": 0.3,
        "species.deer.reproduction.energy_given": 0.2,
        "species.wolf.count": 12,
    },
    "reflexes": {
        "space.size": [30, 30],
        "species.goat.count": 40,
        "species.green.count": 150,
        "species.yellow.count": 80,
        "species.red.count": 10,
    },
    "diel-migration": {
        "species.phytoplankton.count": 60,
        "species.copepod.count": 20,
        "species.krill.count": 3,
    },
    "happiness": {"species.berry.count": 120, "species.nightshade.count": 20, "species.vole.count": 60},
    "innate": {
        "space.size": [30, 30],
        "species.goat.count": 50,
        "species.green.count": 250,
        "species.yellow.count": 60,
        "species.red.count": 10,
    },
    "island": {
        "species.tree.count": 40,
        "species.grass.count": 300,
        "species.deer.count": 60,
        "species.wolf.count": 10,
        "species.raven.count": 20,
    },
    "lamb": {},
    "learning-krill": {
        "species.phytoplankton.count": 60,
        "species.copepod.count": 30,
        "species.krill.count": 8,
    },
    "menagerie": {},
    "examples/dying_world.toml": {
        "species.clover.count": 100,
        "species.hare.count": 50,
        "species.stoat.count": 15,
    },
}
SLOW = [name for i, name in enumerate(WORLDS) if i > 2]


def small(name):
    """The configuration of one of them."""
    return load(MENAGERIE if name == "menagerie" else name, WORLDS[name])
