"""Compare a shipped world with two modified versions, using the same seed."""

import numpy as np

from ecs_eco import World
from ecs_eco.config import load

ARMS = {
    "as shipped": {},
    "half the wolves": {"species.wolf.count": 90},
    "deer run for free": {"species.deer.locomotion.cost.run": 0.0},
}


def numbers(world: World, name: str) -> np.ndarray:
    """Return the population size of a species in each tick."""
    series = world.series()
    return series["n"].to_numpy()[np.array(series["species"].to_pylist()) == name]


if __name__ == "__main__":
    for arm, changes in ARMS.items():
        world = World.from_config(load("predator-prey", changes), seed=1, policies="random").run(60)
        print(
            f"{arm:18} deer {numbers(world, 'deer')[-1]:5}, wolves {numbers(world, 'wolf')[-1]:4}, "
            f"hash {world.digest()[:8]}"
        )
