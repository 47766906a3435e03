"""Vision for a custom torch module: a convolution processes the rays as a small image with a row for each
species."""

import torch
from torch import nn

from ecs_eco import World
from ecs_eco.components import Metabolism

RAYS, KINDS = 15, ["grass", "thistle"]


class Eye(nn.Module):
    """A convolution treats all positions on the retina alike, so it has few weights and learns fast."""

    def __init__(self, n_observations: int, groups: tuple[int, ...]) -> None:
        super().__init__()
        self.retina = nn.Sequential(
            nn.Conv1d(len(KINDS), 8, kernel_size=3, padding=1),
            nn.ReLU(),
            nn.Conv1d(8, 4, kernel_size=3, padding=1),
            nn.ReLU(),
            nn.Flatten(),
        )
        self.policy, self.value = nn.Linear(4 * RAYS + 1, sum(groups)), nn.Linear(4 * RAYS + 1, 1)

    def forward(self, observations: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        energy, image = observations[:, :1], observations[:, 1:].reshape(-1, len(KINDS), RAYS)
        seen = torch.cat([energy, self.retina(image)], dim=1)
        return self.policy(seen), self.value(seen)[:, 0]


plant = {
    "body": {"radius": 0.4},
    "metabolism": {"energy": 0.3},
    "reproduction": {"kind": "spread", "rate": 0.0, "seed_rain": 0.01, "spacing": 1.5},
}
hare = {
    "count": 100,
    "body": {"radius": 0.3},
    "metabolism": {"energy": 0.5, "energy_max": 100.0, "basal": 0.01},
    "locomotion": {"speed": {"hop": 1.0}, "turn": 0.5},
    "diet": [{"eats": "grass", "reach": 0.3, "gain": 0.2}, {"eats": "thistle", "reach": 0.3, "gain": 0.0}],
    "sensors": [
        {"kind": "own", "property": "energy", "scale": 100.0},
        {
            "kind": "rays",
            "name": "eye",
            "count": RAYS,
            "fov": 2.4,
            "range": 8.0,
            "targets": KINDS,
            "report": "per_ray",
        },
    ],
    "actions": {"speed": ["hop"], "turn": ["left", "none", "right"], "eat": ["eat"]},
    "always_on": ["hop"],
    "happiness": {"formula": "energy", "minimum": 0.0},
    "policy": {"kind": "shared", "learn": True, "network": Eye},
    "ppo": {"learning_rate": 0.003, "discount": 0.9, "horizon": 16, "minibatch_size": 800, "epochs": 6},
}

if __name__ == "__main__":
    species = {"grass": plant | {"count": 150}, "thistle": plant | {"count": 150}, "hare": hare}
    heath = {"format": 1, "name": "heath", "space": {"size": [60.0, 60.0]}, "species": species}
    for policy in ("random", "untrained"):
        world = World.from_config(heath, seed=1, policies=policy)
        hares, gains = world.table("hare"), []
        for _ in range(3):
            before = hares[Metabolism].energy[hares.rows()].mean()
            world.run(75)
            gains.append(hares[Metabolism].energy[hares.rows()].mean() - before)
        name = "at random" if policy == "random" else "learning"
        print(f"{name:>9}: {', '.join(f'{gain:+.2f}' for gain in gains)} energy per hare in 75 ticks")
