"""A network with memory, as a custom torch module.

A shadow shows a mouse on which side the owl will appear. When it does, four ticks after the shadow has gone,
the mouse must be on the other side. A network without memory cannot learn this; a GRU can.
"""

import numpy as np
import torch
from torch import nn

from ecs_eco import System, World
from ecs_eco.components import Metabolism, Nervous

PERIOD = 8  # [ticks]: the shadow appears in the first, the owl in the last three


class Remembering(nn.Module):
    """forward(observations f32[n, d], state f32[n, memory]) -> logits f32[n, k], values f32[n], state."""

    memory = 16  # numbers stored per organism; zero at birth

    def __init__(self, n_observations: int, groups: tuple[int, ...]) -> None:
        super().__init__()
        self.cell = nn.GRUCell(n_observations, self.memory)
        self.policy, self.value = nn.Linear(self.memory, sum(groups)), nn.Linear(self.memory, 1)

    def forward(self, observations: torch.Tensor, state: torch.Tensor) -> tuple[torch.Tensor, ...]:
        state = self.cell(observations, state)
        return self.policy(state), self.value(state)[:, 0], state


def side(world, uid: np.ndarray) -> np.ndarray:
    """Return the owl's side in this period for each mouse: -1 or 1."""
    mixed = uid * np.uint64(2654435761) + np.uint64(world.tick // PERIOD * 40503)
    return 1 - 2 * (mixed >> np.uint64(9) & np.uint64(1)).astype(int)


def shadow(world, table, seekers, out, first) -> None:
    """Sense the side in the first tick of a period, otherwise 0."""
    out[:, first] = side(world, table.uid[seekers.rows]) * (world.tick % PERIOD == 0)


class Owl(System):
    """In the last ticks of a period, hurt the mice on the owl's side and feed the others."""

    needs = (Nervous, Metabolism)
    phase = "interact"
    acts = ("side",)

    def update(self, table, world) -> None:
        if world.tick % PERIOD >= PERIOD - 3:
            m, rows, step = table[Metabolism], table.rows(), np.float32(0.005)
            safe = table.species.nerves.doing(table, "left")[rows] == (side(world, table.uid[rows]) > 0)
            m.energy[rows] += np.where(safe, step, -step)
            m.taken[rows] += step * safe
            m.burnt[rows] += step * ~safe


mouse = {
    "count": 300,
    "body": {"radius": 0.05},
    "metabolism": {"energy": 0.5},
    "sensors": [{"kind": "own", "property": "energy"}, {"kind": "custom", "function": shadow}],
    "actions": {"side": ["left", "right"]},
    "happiness": {"formula": "energy", "minimum": 0.0},
    "policy": {"kind": "shared", "learn": True},
    "ppo": {"learning_rate": 0.01, "discount": 0.9, "horizon": 16, "epochs": 6, "unroll": 8},
}

if __name__ == "__main__":
    for name, network in (("built-in", None), ("GRU", Remembering)):
        species = mouse | {"policy": mouse["policy"] | {"network": network}}
        barn = {"format": 1, "name": "barn", "space": {"size": [10.0, 10.0]}, "species": {"mouse": species}}
        world = World.from_config(barn, systems=[Owl()], seed=1).run(240)
        mice = world.table("mouse")
        before = mice[Metabolism].energy[mice.rows()].mean()
        world.run(5 * PERIOD)
        gain = (mice[Metabolism].energy[mice.rows()].mean() - before) / (5 * 3 * 0.005)
        print(f"{name:>8}: {(1 + gain) / 2:4.0%} of the mice on the safe side")
