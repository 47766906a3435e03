"""Couples of deer that are ready to mate, and what came of it."""

import numpy as np

from ecs_eco.components import Gestation
from ecs_eco.engine import random
from ecs_eco.systems import GiveBirth, Mate
from ecs_eco.testing import act, arrange

# bodies of 0.5 m: centres within 2 m
WAY = {"kind": "sexual", "energy_min": 0.5, "energy_given": 0.25, "reach": 1.0}
WIDE = {"space": {"size": [400.0, 400.0]}}
FEMALE, MALE = 1, 2


def mate(world):
    """Let deer mate; return {mother: father} by number, the first deer being 0."""
    act(world, Mate)
    deer = world.tables["deer"]
    g, rows = deer[Gestation], deer.by_uid()
    first = int(deer.uid[rows[0]])
    return {i: int(g.father[r]) - first for i, r in enumerate(rows) if g.carrying[r]}


def couples_of(meadow, n, **changes):
    """A world of n couples, each 10 m from the next, the female first, 1 m before the male; all are ready."""
    way = WAY | changes.pop("reproduction", {})
    world = meadow(
        count=2 * n, sex="random", world=WIDE | changes.pop("world", {}), reproduction=way, **changes
    )
    x = np.repeat(10.0 * np.arange(n), 2) + np.tile([0.0, 1.0], n)
    arrange(
        world,
        "deer",
        x=x % 400,
        y=10.0 + 10 * np.floor(x / 400),
        sex=np.tile([FEMALE, MALE], n),
        energy=0.75,
        age=20.0,
    )
    return world


def mate_and_give_birth(world):
    act(world, Mate)
    act(world, GiveBirth)
    world.flush()


def values_by_uid(world, component, field):
    deer = world.tables["deer"]
    return deer.field(component, field)[deer.by_uid()]


# the slow twin


def mix(z):
    return int(random.mix(np.uint64(z)))


def plain_draw(key, who, purpose):
    return float(random.draw(key, np.uint64(who), purpose))
