"""A small world with births and deaths, in which a species lives on whatever it does."""

from copy import deepcopy

PASTURE = {
    "format": 1,
    "name": "pasture",
    "ticks": 20_000,
    "space": {"size": [10.0, 10.0]},
    "species": {
        "grass": {
            "count": 12,
            "color": "#4d9221",
            "body": {"radius": 0.2, "opaque": False},
            "metabolism": {"energy": 0.2, "energy_max": 0.2, "basal": 0.0},
            "reproduction": {"kind": "spread", "rate": 0.1, "seed_rain": 0.05, "spacing": 2.0},
        },
        "deer": {
            "count": 6,
            "max_count": 9,
            "age": [0.0, 100.0],
            "body": {"radius": 0.3},
            "metabolism": {"energy": 0.6, "energy_max": 1.0, "basal": 0.001},
            "locomotion": {
                "speed": {"still": 0.0, "walk": 0.5},
                "cost": {"still": 0.0, "walk": 0.001},
                "turn": 0.8,
            },
            "diet": [{"eats": "grass", "gain": 0.2}],
            "sensors": [
                {"kind": "own", "property": "energy"},
                {"kind": "nearest", "target": "grass", "range": 4.0},
            ],
            "actions": {"speed": ["still", "walk"], "turn": ["left", "none", "right"], "eat": ["eat"]},
            "always_on": ["eat"],
            "happiness": {"formula": "energy", "minimum": -1.0},
            "policy": {"kind": "external"},
            "reproduction": {
                "kind": "asexual",
                "place": "anywhere",
                "rate": 0.1,
                "energy_min": 0.2,
                "energy_given": 0.01,
            },
            "lethal": [
                {"property": "energy", "min": 0.0, "cause_below": "starved"},
                {"property": "age", "max": 120.0, "cause_above": "old age"},
            ],
        },
    },
}

ROAMING = deepcopy(PASTURE)
"""The same, where deer choose a speed among two, and any turn between two."""
ROAMING["species"]["deer"]["actions"]["turn"] = {"continuous": [-0.8, 0.4]}
