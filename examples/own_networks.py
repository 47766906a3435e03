"""Reflex and happiness as custom functions instead of formulas."""

import numpy as np

from ecs_eco import World
from ecs_eco.components import Nervous

# channels, in sensor order: energy, grass_forward, grass_left, grass_near (`ecs-eco check FILE` lists them)
# actions, in group order: sit, hop, left, none, right, eat


def reflex(x: np.ndarray) -> np.ndarray:
    """Map x f32[n, channels] to [n, actions]; only the sign matters: + forces, − blocks, 0 leaves the choice
    to the policy."""
    y = np.zeros((len(x), 6), np.float32)
    close = x[:, 3] > 0.9
    y[close, 1] = -1  # do not hop past food within reach
    y[:, 5] = 1  # always eat
    return y


def happiness(x: np.ndarray) -> np.ndarray:
    """Map x f32[n, channels] to f32[n]: the lower the energy, the more a loss hurts."""
    return np.sqrt(np.clip(x[:, 0], 0, 1))


grass = {
    "count": 400,
    "body": {"radius": 0.4, "opaque": False},
    "reproduction": {"kind": "spread", "rate": 0.1, "seed_rain": 0.01, "spacing": 2.0},
}
rabbit = {
    "count": 60,
    "body": {"radius": 0.3},
    "metabolism": {"energy": 0.5, "basal": 0.01},
    "locomotion": {"speed": {"sit": 0.0, "hop": 1.0}, "turn": 0.8},
    "diet": [{"eats": "grass", "reach": 0.3, "gain": 0.2}],
    "sensors": [{"kind": "own", "property": "energy"}, {"kind": "nearest", "target": "grass", "range": 5.0}],
    "actions": {"speed": ["sit", "hop"], "turn": ["left", "none", "right"], "eat": ["eat"]},
    "reflex": {"function": reflex},  # in a file: function = "own_networks:reflex"
    "happiness": {"function": happiness, "minimum": 0.0},
    "policy": {"kind": "shared"},
}

if __name__ == "__main__":
    meadow = {
        "format": 1,
        "name": "meadow",
        "space": {"size": [50.0, 50.0]},
        "species": {"grass": grass, "rabbit": rabbit},
    }
    world = World.from_config(meadow).run(100)
    rabbits = world.table("rabbit")
    print(world)
    print(f"mean happiness {rabbits[Nervous].happiness[rabbits.rows()].mean():.2f}")
