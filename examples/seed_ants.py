"""Ants carry seeds home to a queen, which cannot move and lives on the seeds."""

import copy
from typing import Any

from ecs_eco import World
from ecs_eco.components import Load, Metabolism

HILL: dict[str, Any] = {
    "format": 1,
    "name": "ant-hill",
    "space": {"size": [40.0, 40.0]},
    "objects": {
        "seed": {
            "count": 150,
            "renewal": 0.002,
            "energy": {"initial": 0.1},
            "color": "#b8860b",
            "body": {"radius": 0.1, "mass": 0.002, "opaque": False},
        }
    },
    "species": {
        "queen": {
            "count": 1,
            "body": {"radius": 0.5, "opaque": False},
            "color": "#67001f",
            "metabolism": {"energy": 1.0, "energy_max": 50.0, "basal": 0.02},
            "diet": [{"eats": "seed", "reach": 2.0, "efficiency": 1.0}],
            "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
        },
        "ant": {
            "count": 30,
            "body": {"radius": 0.15, "mass": 0.001, "opaque": False},
            "color": "#222222",
            "locomotion": {"speed": {"walk": 1.0}, "turn": 1.0},
            "carries": [{"object": "seed", "reach": 0.1}],
            "sensors": [
                {"kind": "own", "property": "load", "scale": 0.002},
                {"kind": "nearest", "target": "seed", "range": 4.0},
                {"kind": "nearest", "target": "queen", "range": 20.0},
            ],
            "actions": {
                "speed": ["walk"],
                "turn": ["left", "none", "right"],
                "carry": ["take", "none", "drop"],
            },
            "default_action": {"turn": "none", "carry": "none"},
            "always_on": ["walk"],
        },
    },
}
# with a seed, to the queen; without one, to the nearest seed, unless already near the queen
GOAL = "(queen_{0} if load > 0.5 else seed_{0} if queen_near < 0.8 else 0)"
LEFT, AHEAD = GOAL.format("left"), GOAL.format("forward")
HILL["species"]["ant"]["reflex"] = {
    "formulas": {
        "left": f"1 if {LEFT} > 0.2 or ({AHEAD} < 0 and {LEFT} >= 0) else -1",
        "right": f"1 if {LEFT} < -0.2 else -1",
        "take": "1 if load < 0.5 and queen_near < 0.8 else -1",
        "drop": "1 if load > 0.5 and queen_near > 0.92 else -1",
    }
}


def lived(carrying: bool, ticks: int = 600) -> World:
    """Return an anthill after ten minutes, with ants that do or do not carry seeds."""
    config = copy.deepcopy(HILL)
    if not carrying:
        config["species"]["ant"]["reflex"]["formulas"]["take"] = "-1"
    return World.from_config(config, seed=3).run(ticks)


if __name__ == "__main__":
    for carrying in (True, False):
        world = lived(carrying)
        queen, ant = world.tables["queen"], world.tables["ant"]
        eaten = sum(world.series().to_pydict()["taken_in"]) / 0.1
        state = f"has an energy of {queen[Metabolism].energy[0]:.1f}" if queen.n else "has starved"
        laden = int((ant[Load].object[ant.rows()] > 0).sum())
        print(
            f"ants that {'carry' if carrying else 'do not carry'}: {laden} hold a seed, "
            f"the queen has eaten {eaten:.0f} seeds and {state}"
        )
