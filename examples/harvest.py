"""Harvest: every year, a share of a fish stock is caught, and the stock regrows."""

import numpy as np

from ecs_eco import World
from ecs_eco.config import load

YEAR = 40  # ticks
POND = {
    "format": 1,
    "name": "pond",
    "ticks": 10 * YEAR,
    "space": {"size": [60.0, 60.0]},
    "species": {
        "fish": {
            "count": 200,
            "max_count": 5000,
            "body": {"radius": 0.1, "opaque": False},
            "metabolism": {"energy": 0.5, "energy_max": 1.0, "photosynthesis": 0.02},
            "reproduction": {
                "kind": "asexual",
                "place": "anywhere",
                "rate": 0.03,
                "energy_min": 0.8,
                "energy_given": 0.4,
                "spacing": 2.0,
            },
            "lethal": [{"property": "age", "max": 100.0, "cause_above": "too old"}],
        }
    },
}


def fished(share: float, region: list[float] | None = None) -> World:
    """Return a pond where this share of the fish is caught at the end of each year, either everywhere or only
    in the fished half."""
    catch = {
        "kind": "cull",
        "at": YEAR,
        "every": YEAR,
        "species": "fish",
        "share": share,
        "which": "oldest",
        "cause": "caught",
    }
    plan = [catch | ({"region": region} if region else {})] if share else []
    return World.from_config(load(POND | {"interventions": plan}), seed=1).run(POND["ticks"])


if __name__ == "__main__":
    for share in (0.0, 0.2, 0.5, 0.8):
        for where, region in (("everywhere", None), ("in one half", [0.0, 0.0, 30.0, 60.0])):
            world = fished(share, region)
            series = world.series().to_pydict()
            caught = int(np.sum(series.get("died: caught", 0)))
            print(
                f"{share:4.0%} a year {where:12}: {series['n'][-1]:4} fish left, "
                f"{caught:5} caught in {len(world.intervened)} years"
            )
            if share == 0:
                break
