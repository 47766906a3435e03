"""A custom action group, `shelter`: a system reads the decision and carries it out. A hidden snail is safe
from hail but does not graze. Its policy learns when to hide.
"""

import numpy as np

from ecs_eco import System, World
from ecs_eco.components import Metabolism, Nervous


class Shelter(System):
    """Feed snails that stay outside, and hurt them while it hails."""

    needs = (Nervous, Metabolism)
    phase = "interact"
    acts = ("shelter",)  # action groups that this system carries out

    def update(self, table, world) -> None:
        out = table.species.nerves.doing(table, "stay")
        m, gain = table[Metabolism], np.float32(0.002 * world.dt)
        m.energy[out] += gain
        m.taken[out] += gain
        if hails(world):
            m.energy[out] -= 3 * gain
            m.burnt[out] += 3 * gain


def hails(world) -> bool:
    """Return whether it hails: ten seconds of sun, then ten of hail."""
    return world.time // 10 % 2 == 1


def sky(world, table, seekers, out, first) -> None:
    """Sense hail: 1 while it hails."""
    out[:, first] = hails(world)


snail = {
    "count": 200,
    "body": {"radius": 0.02},
    "metabolism": {"energy": 0.5},
    "sensors": [{"kind": "own", "property": "energy"}, {"kind": "custom", "function": sky}],
    "actions": {"shelter": ["stay", "hide"]},
    "happiness": {"formula": "energy", "minimum": 0.0},
    "policy": {"kind": "shared", "hidden": [16], "learn": True},
    "ppo": {"learning_rate": 0.01, "discount": 0.5},
}

if __name__ == "__main__":
    garden = {"format": 1, "name": "garden", "space": {"size": [10.0, 10.0]}, "species": {"snail": snail}}
    world = World.from_config(garden, systems=[Shelter()])
    snails = world.table("snail")
    for _ in range(4):
        share = {}
        for weather in ("sun", "hail"):
            world.run(10)
            share[weather] = snails.species.nerves.doing(snails, "hide").sum() / snails.n
        print(f"tick {world.tick:3}: {share['hail']:4.0%} hide in hail, {share['sun']:4.0%} in the sun")
        world.run(180)
