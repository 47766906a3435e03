"""Hares sit in a pen, and dogs run around it. A ditch neither hides the hares nor stops the dogs; a hedge
only hides the hares; a fence only stops the dogs; a wall does both."""

import copy

import numpy as np

from ecs_eco import World
from ecs_eco.components import Position

LOW, HIGH = 14.0, 26.0  # [m] corners of the pen
PEN = [[LOW, LOW, HIGH, LOW], [HIGH, LOW, HIGH, HIGH], [HIGH, HIGH, LOW, HIGH], [LOW, HIGH, LOW, LOW]]

yard = {
    "format": 1,
    "name": "yard",
    "dt": 0.25,
    "space": {"size": [40.0, 40.0], "edges": "walls"},
    "objects": {"side": {"between": PEN, "body": {"shape": "box", "size": [12.0, 0.3, 1.5]}}},
    "species": {
        "hare": {"count": 60, "body": {"radius": 0.2, "opaque": False}},
        "dog": {
            "count": 12,
            "body": {"shape": "capsule", "radius": 0.2, "length": 1.0, "solid": True, "opaque": False},
            "metabolism": {"energy_max": 100.0},
            "locomotion": {"speed": {"run": 4.0}, "turn": 3.0},
            "diet": [{"eats": "hare", "gain": 0.1}],
            "sensors": [{"kind": "nearest", "target": "hare", "range": 40.0, "occlusion": True}],
            "actions": {"speed": ["run"], "turn": ["left", "none", "right"]},
            "always_on": ["run"],
            "default_action": {"turn": "none"},
            "reflex": {"formulas": {"left": "hare_left - 0.1", "right": "-hare_left - 0.1"}},
        },
    },
}


def build(solid: bool, opaque: bool) -> World:
    """Return a yard with dogs to the left of a hare pen whose sides may stop dogs and hide hares."""
    config = copy.deepcopy(yard)
    config["objects"]["side"]["body"] |= {"solid": solid, "opaque": opaque}
    world, rng = World.from_config(config, seed=1, policies="random"), np.random.default_rng(1)
    for name, left, right in (("hare", LOW + 1, HIGH - 1), ("dog", 2.0, LOW - 2)):
        table = world.table(name)
        p, rows = table[Position], table.by_uid()
        p.x[rows] = rng.uniform(left, right, rows.size)
        p.y[rows] = rng.uniform(LOW + 1, HIGH - 1, rows.size)
        table.version += 1
    return world


if __name__ == "__main__":
    for name, solid, opaque in (
        ("ditch", False, False),
        ("hedge", False, True),
        ("fence", True, False),
        ("wall", True, True),
    ):
        world = build(solid, opaque).run(1)
        dogs = world.table("dog")
        nerves = dogs.species.nerves
        seeing = int((nerves.x[:, nerves.channels.index("hare_near")] > 0).sum())
        hares = world.table("hare")
        world.run(239)
        caught = 60 - hares.n
        print(f"{name}: {seeing} of {dogs.n} dogs see a hare at first; {caught} hares are caught in a minute")
