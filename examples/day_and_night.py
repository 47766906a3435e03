"""A changing environment: algae grow with light, which depends on time and position."""

import numpy as np

from ecs_eco import World
from ecs_eco.components import Metabolism

DAY = 100.0  # [s]


def light(world: World, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return the light at positions [m]: the sun rises and sets, and water dims it by exp(-0.2 depth)."""
    sun = max(0.0, np.sin(2 * np.pi * world.time / DAY))
    return (sun * np.exp(-0.2 * (30.0 - z))).astype(np.float32)


algae = {
    "count": 500,
    "body": {"radius": 0.1, "opaque": False},
    "metabolism": {"energy": 0.5, "basal": 0.004, "photosynthesis": 0.04},
    "lethal": [{"property": "energy", "min": 0.0, "cause_below": "dark"}],
}

if __name__ == "__main__":
    lake = {
        "format": 1,
        "name": "lake",
        "space": {"size": [30.0, 30.0, 30.0], "edges": "walls"},
        "species": {"algae": algae},
    }
    world = World.from_config(lake)
    world.environment["light"] = light
    for _ in range(4):
        world.run(50)
        table = world.table("algae")
        print(
            f"after {world.time:3.0f} s: {table.n} algae, "
            f"mean energy {table[Metabolism].energy[table.rows()].mean():.2f}"
        )
