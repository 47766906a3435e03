"""Pre-train policies with constant population sizes, then run the ecosystem with and without learning during
life."""

import tempfile

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.lab.pretraining import pretrain

SMALL = {
    "space.size": [64.0, 64.0],
    "species.grass.count": 400,
    "species.deer.count": 120,
    "species.wolf.count": 12,
}

if __name__ == "__main__":
    config = load("predator-prey", SMALL)
    with tempfile.TemporaryDirectory() as folder:
        result = pretrain(config, seed=1, ticks=400, out=folder, points=4)
        for species in ("deer", "wolf"):
            curve = result["curves"][species]
            print(f"{species}: deaths per animal per second {', '.join(f'{v:.4f}' for v in curve['deaths'])}")
        for learn in (False, True):
            world = World.from_config(config, seed=1, policies=folder, learn=learn).run(200)
            print(f"learning {'on ' if learn else 'off'}: {world}")
