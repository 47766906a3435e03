"""Change a meadow's values one at a time, and see how many hares and how much grass it supports.
`python examples/carrying_capacity.py 3000 3` runs each meadow for 3,000 ticks with 3 seeds."""

import sys

import numpy as np

from ecs_eco import World
from ecs_eco.config import load

MEADOW = {
    "format": 1,
    "name": "meadow",
    "space": {"size": [60.0, 60.0]},
    "species": {
        "grass": {
            "count": 400,
            "body": {"radius": 0.2, "opaque": False},
            "reproduction": {"kind": "spread", "rate": 0.02, "seed_rain": 0.002, "spacing": 2.0},
        },
        "hare": {
            "count": 60,
            "body": {"radius": 0.3},
            "metabolism": {"energy": 0.5, "basal": 0.01},
            "locomotion": {"speed": {"walk": 0.5}},
            "wander": {"turn": 0.3, "gait": "walk"},
            "diet": [{"eats": "grass", "reach": 0.5, "gain": 0.2, "satiation": 0.8}],
            "reproduction": {"kind": "asexual", "rate": 0.005, "energy_min": 0.6, "energy_given": 0.3},
            "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
        },
    },
}
CHANGES = {
    "as it is": {},
    "grass grows twice as fast": {
        "species.grass.reproduction.rate": 0.04,
        "species.grass.reproduction.seed_rain": 0.004,
    },
    "hares burn half": {"species.hare.metabolism.basal": 0.005},
    "a tuft feeds twice as much": {"species.hare.diet.0.gain": 0.4},
    "hares reach 1 m farther": {"species.hare.diet.0.reach": 1.5},
    "twice the area": {"space.size": [60.0, 120.0], "species.grass.count": 800, "species.hare.count": 120},
}


def carried(changes: dict, seed: int, ticks: int) -> tuple[float, float, float]:
    """Return the mean number of hares, the share of sites with grass, and the number of hares that the energy
    could feed."""
    world = World.from_config(load(MEADOW, changes), seed=seed).run(ticks)
    late = world.series().to_pandas().query("tick > @ticks // 3")
    hare, grass = (late[late["species"] == name] for name in ("hare", "grass"))
    sites = world.space.size[0] * world.space.size[1] / 4
    fed = (hare["taken_in"].mean() - hare["lost"].mean()) / world.config.species["hare"].metabolism.basal
    return hare["n"].mean(), grass["n"].mean() / sites, fed


if __name__ == "__main__":
    ticks, seeds = (int(x) for x in (sys.argv[1:] or ["300", "1"]))
    for name, changes in CHANGES.items():
        hares, share, fed = np.mean([carried(changes, seed, ticks) for seed in range(1, seeds + 1)], 0)
        print(f"{name}: {hares:.0f} hares, grass on {share:.2f} of the sites; energy feeds {fed:.0f}")
