"""Ducklings hatch, follow their mother, are fed by her and grow up. Ducklings that do not follow her
starve."""

import numpy as np

from ecs_eco import World
from ecs_eco.components import Body, Parentage, Position
from ecs_eco.config import load

SECONDS = 300
DUCK = {
    "count": 20,
    "sex": "female",
    "body": {"radius": 0.25, "mass": 1.0, "opaque": False},
    "metabolism": {"energy": 2.5, "energy_max": 3.0, "basal": 5e-4},
    "growth": {"law": "west", "rate": 0.02, "newborn": 0.05, "cost": 0.1, "reserve": 0.03, "pace": 0.05},
    "care": {"rate": 2e-3, "reach": 0.5, "age_max": 200.0, "reserve": 0.5},
    "locomotion": {"speed": {"still": 0.0, "swim": 1.0}, "cost": {"swim": 2e-4}, "turn": 0.8},
    "sensors": [{"kind": "nearest", "name": "mother", "target": "duck", "range": 15.0, "kin": "mother"}],
    "actions": {"speed": ["still", "swim"], "turn": ["left", "none", "right"]},
    "default_action": {"speed": "still", "turn": "none"},
    # without a mother, all readings are 0, and ducks swim about as their policy decides
    "reflex": {
        "formulas": {
            "left": "mother_left",
            "right": "-mother_left",
            "none": "-mother_near",
            "swim": "mother_near * (0.96 - mother_near)",
        }
    },
    "policy": {"kind": "shared"},
    "happiness": {"weights": {"mother_near": 1.0}, "minimum": 0.0},
    "reproduction": {
        "kind": "asexual",
        "rate": 0.05,
        "energy_min": 2.4,
        "energy_given": 0.05,
        "litter": 4,
        "dispersal": 1.0,
        "eggs": "duck_egg",
    },
    "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
}
EGG = {
    "count": 0,
    "body": {"radius": 0.03, "mass": 0.05, "opaque": False},
    "metabolism": {"energy": 0.05},
    # 30 s at 310 K, 37.5 s at this pond's 302.2 K
    "hatch": {"into": "duck", "incubation": 30.0, "temperature": 310.0, "threshold": 271.0},
}
CROW = {
    "count": 3,
    "body": {"radius": 0.2, "opaque": False},
    "metabolism": {"energy": 0.5},
    "locomotion": {"speed": {"fly": 2.0}, "turn": 0.8},
    "diet": [{"eats": "duck_egg", "efficiency": 0.5}],
    "sensors": [{"kind": "nearest", "target": "duck_egg", "range": 4.0}],
    "actions": {"speed": ["fly"], "turn": ["left", "none", "right"]},
    "default_action": {"speed": "fly", "turn": "none"},
    "reflex": {"formulas": {"left": "duck_egg_left", "right": "-duck_egg_left", "none": "-duck_egg_near"}},
}
POND = {
    "format": 1,
    "name": "pond",
    "space": {"size": [40.0, 40.0]},
    "ambient": {"temperature": 302.2},
    "species": {"duck": DUCK, "duck_egg": EGG, "crow": CROW},
}


def from_mother(world: World) -> float:
    """Return the mean distance between the young and their living mothers [m]."""
    duck = world.table("duck")
    rows = dict(zip(duck.uid[duck.rows()].tolist(), duck.rows().tolist(), strict=True))
    pairs = [(row, rows[her]) for row in rows.values() if (her := int(duck[Parentage].mother[row])) in rows]
    young, mother = np.array(pairs, int).reshape(-1, 2).T
    away = [abs(place[young] - place[mother]) for place in (duck[Position].x, duck[Position].y)]
    return float(np.hypot(*(np.minimum(a, 40 - a) for a in away)).mean()) if young.size else np.nan


if __name__ == "__main__":
    for controls in ([], ["no-reflexes"]):
        world = World.from_config(load(POND), seed=1, policies="random", controls=controls)
        world.run(100)
        distance = from_mother(world)
        series = world.run(SECONDS - 100).series().to_pydict()
        species, duck = np.array(series["species"]), world.table("duck")
        fate = {c: int(np.sum(series.get(f"died: {c}", 0))) for c in ("eaten by crow", "hatched", "starved")}
        grown = duck[Body].mass[duck.rows()][duck[Parentage].mother[duck.rows()] > 0]
        laid = int(np.sum(np.array(series["births"])[species == "duck_egg"]))
        print(
            f"{'follow their mother' if not controls else 'swim anywhere'}: of {laid} eggs, crows ate "
            f"{fate['eaten by crow']} and {fate['hatched']} hatched; after 100 s, {distance:.1f} m from "
            f"their mothers; {fate['starved']} starved, {len(grown)} survive with a mean mass of "
            f"{grown.mean() if grown.size else 0:.2f} kg"
        )
