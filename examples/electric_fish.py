"""Weakly electric fish in the dark: each fish senses the currents of other fish on both flanks and turns
toward the stronger side. Schools form, but not among fish without electric discharge."""

import copy

import numpy as np

from ecs_eco import World
from ecs_eco.components import Position

SIDE, FISH = 60.0, 80  # [m], number of fish


def flank(name: str, left: float) -> dict:
    """Return a receptor this many radii to the left of the fish's center. It senses currents within 15 m,
    weakened by the square of the distance."""
    return {
        "kind": "property",
        "name": name,
        "property": "electric_current",
        "of": "knifefish",
        "range": 15.0,
        "decay": "inverse_square",
        "at": [0.0, left],
        "scale": 1e-3,
    }


river = {
    "format": 1,
    "name": "river",
    "space": {"size": [SIDE, SIDE]},
    "ambient": {"light": 0.0},
    "species": {
        "knifefish": {
            "count": FISH,
            "body": {"radius": 0.25},
            "properties": {"electric_current": 1e-3},  # [A]
            "locomotion": {"speed": {"swim": 0.4}, "turn": 0.4},
            "sensors": [flank("port", 1.0), flank("starboard", -1.0)],
            "actions": {"speed": ["swim"], "turn": ["left", "none", "right"]},
            "always_on": ["swim"],
            "default_action": {"turn": "none"},
            "reflex": {"formulas": {"left": "port - starboard > 1e-4", "right": "starboard - port > 1e-4"}},
        }
    },
}


def to_nearest(world: World) -> float:
    """Return the mean distance to the nearest fish [m]."""
    fish = world.table("knifefish")
    p, rows = fish[Position], fish.rows()
    away = [v[rows][:, None] - v[rows][None] for v in (p.x, p.y)]
    x, y = (d - SIDE * np.round(d / SIDE) for d in away)
    distance = np.hypot(x, y) + np.diag(np.full(rows.size, np.inf))
    return float(distance.min(axis=1).mean())


if __name__ == "__main__":
    silent = copy.deepcopy(river)
    silent["species"]["knifefish"]["properties"]["electric_current"] = 0.0
    for name, config in (("electric", river), ("silent", silent)):
        world = World.from_config(config, seed=1, policies="random")
        distances = [to_nearest(world)] + [to_nearest(world.run(50)) for _ in range(4)]
        print(f"{name:>8}: {', '.join(f'{d:.1f}' for d in distances)} m to the nearest fish, every 50 s")
