"""Nitrogen cycles from soil into grass, voles and carcasses and back; without decay, it stays locked up in
carcasses."""

import numpy as np

from ecs_eco import World

DAY = 24.0  # [ticks], each one hour long
GRASS = {
    "count": 500,
    "body": {"radius": 0.05, "opaque": False},  # half a liter
    "substances": {"nitrogen": 0.3},
    "born_with": "soil",  # a seed sprouts if the soil around it contains 0.16 mol
    "metabolism": {"energy": 0.2, "energy_max": 1.0, "photosynthesis": 0.02},
    "reproduction": {"kind": "spread", "rate": 0.04, "spacing": 0.5, "place": "near", "dispersal": 2.0},
    "lethal": [{"property": "age", "max": 20 * DAY}],
    "remains": "litter",
}
VOLE = {
    "count": 60,
    "body": {"radius": 0.08, "opaque": False},
    "substances": {"nitrogen": 0.5},
    "born_with": "mother",
    "metabolism": {"energy": 0.6, "energy_max": 1.0, "basal": 0.012},
    "locomotion": {"speed": {"walk": 0.4}, "turn": 1.5},
    "diet": [{"eats": "grass", "reach": 0.1, "gain": 0.1, "assimilation": 0.4}],  # the rest becomes dung
    "exchange": [{"kind": "release", "substance": "nitrogen", "field": "soil", "rate": 0.02, "above": 0.5}],
    "actions": {"speed": ["walk"], "turn": ["left", "none", "right"]},
    "always_on": ["walk"],
    "reproduction": {
        "kind": "asexual",
        "rate": 0.01,
        "energy_min": 0.7,
        "energy_given": 0.3,
        "dispersal": 1.0,
    },
    "lethal": [
        {"property": "energy", "min": 0.0, "cause_below": "starved"},
        {"property": "age", "max": 40 * DAY},
    ],
    "remains": "carcass",
}


def meadow(decay: float) -> World:
    """Return a meadow whose carcasses release this share of their nitrogen per hour."""
    dead = {"body": {"radius": 0.08, "opaque": False}, "decomposition": {"rate": decay}}
    return World.from_config(
        {
            "format": 1,
            "name": "meadow",
            "ticks": 1500,
            "space": {"size": [20.0, 20.0]},
            "substances": {"nitrogen": "in proteins and in the soil"},
            "fields": {
                "soil": {
                    "cell": 1.0,
                    "depth": 0.1,
                    "diffusion": 1e-3,
                    "substance": "nitrogen",
                    "initial": 0.004,
                }
            },
            "objects": {"litter": dead, "carcass": dead},
            "species": {"grass": GRASS, "vole": VOLE},
        },
        policies="random",
        seed=1,
    )


if __name__ == "__main__":
    for decay in (0.02, 1e-6):
        world = meadow(decay).run(1500)
        page = world.recorder.matter_series().to_pydict()
        rows = zip(page["tick"], page["holder"], page["stock_after"], strict=True)
        held = {name: amount for tick, name, amount in rows if tick == world.tick - 1}
        total = np.reshape(page["stock_after"], (world.tick, -1)).sum(1)
        where = ", ".join(f"{100 * amount / total[-1]:.0f}% in {name}" for name, amount in held.items())
        print(
            f"decay of {decay:g} per hour: {world.table('grass').n} grass, {world.table('vole').n} voles; "
            f"nitrogen: {where}; total {total[0]:.1f} mol at first, {total[-1]:.1f} mol at the end"
        )
