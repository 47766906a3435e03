"""Worlds whose nervous systems are drawn: a lamb, one with genes, and one with very many senses."""

from __future__ import annotations

import copy
from typing import Any

from ecs_eco import System
from ecs_eco.config import WorldConfig, load


class Stomach(System):
    acts = ("homeostasis",)

    def process(self) -> None:
        """Nothing: only the group of actions matters here."""


def noses(field: str) -> list[dict[str, Any]]:
    return [{"kind": "smell", "field": field, "at": [1.0, side]} for side in (0.5, -0.5)]


LAMB: dict[str, Any] = {
    "format": 1,
    "name": "meadow",
    "space": {"size": [40.0, 40.0], "edges": "torus"},
    "fields": {n: {"cell": 2.0, "diffusion": 0.5, "decay": 0.1} for n in ("milk_smell", "sheep_smell")},
    "substances": {"glucose": "blood sugar", "oxygen": "in blood"},
    "systems": [Stomach],
    "species": {
        "lamb": {
            "count": 3,
            "body": {"radius": 0.3, "mass": 5.0},
            "substances": {"glucose": 0.005, "oxygen": 0.01},
            "locomotion": {"speed": {"still": 0.0, "walk": 0.5}},
            "sensors": [
                *noses("milk_smell"),
                *noses("sheep_smell"),
                {"kind": "touch", "name": "lips", "at": [-0.5, 0.5]},
                {"kind": "touch", "name": "water_on_nose", "target": "wall"},
                {"kind": "own", "property": "glucose", "scale": 0.005},
                {"kind": "own", "property": "oxygen", "scale": 0.01},
            ],
            "actions": {"speed": ["still", "walk"], "homeostasis": ["suck", "inhale"]},
            "reflex": {
                "connections": [
                    {"sensor": "lips", "action": "suck", "weight": 1, "above": 0.5},
                    {"sensor": "water_on_nose", "action": "inhale", "weight": -1, "above": 0.5},
                ]
            },
            "happiness": {"weights": {"glucose": 1.0, "oxygen": -0.5}, "minimum": -1.0},
        }
    },
}


def lamb(**changes: Any) -> WorldConfig:
    data = copy.deepcopy(LAMB)
    data["species"]["lamb"] |= changes
    return load(data)


def many() -> WorldConfig:
    """A lamb of 40 channels with ten reflexes, four of them for one action, and lines of every kind."""
    eye = {"kind": "rays", "name": "eye", "count": 32, "range": 5.0, "targets": ["lamb"], "report": "per_ray"}
    reflex = copy.deepcopy(LAMB["species"]["lamb"]["reflex"])
    for threshold in (0.1, 0.2, 0.3):
        reflex["connections"] += [
            {"sensor": "glucose", "action": a, "weight": 1, "below": threshold} for a in ("suck", "walk")
        ]
    reflex["formulas"] = {
        "inhale": "0.3 - oxygen + min(eye_lamb_3, "
        "eye_lamb_30) * (lips > 0.5 or water_on_nose > 0.25) - milk_smell"
    }
    reflex["connections"].append({"sensor": "sheep_smell", "action": "still", "weight": 0, "above": 0.5})
    happiness = {"formula": "tanh(glucose) - oxygen + (lips - milk_smell) ** 2", "minimum": -1.0}
    return lamb(sensors=[*LAMB["species"]["lamb"]["sensors"], eye], reflex=reflex, happiness=happiness)


GENES = [
    {"name": "courage", "trait": "reflex.lips_suck.weight", "letters": 1, "values": [0, 0, 0, -1]},
    {"name": "skin", "trait": "reflex.lips_suck.threshold", "letters": 2, "low": 0, "high": 1},
    {"name": "either", "trait": "reflex.dive.weight", "letters": 1, "values": [1, 0, 0, -1]},
    {"name": "greed", "trait": "happiness.glucose", "letters": 2, "low": -1, "high": 1},
    {"name": "nose", "trait": "sensors.milk_smell_1.left", "letters": 2, "low": 0, "high": 1},
    {"name": "neutral", "letters": 1, "values": [0, 1, 2, 3]},
]


def heritable() -> WorldConfig:
    reflex = copy.deepcopy(LAMB["species"]["lamb"]["reflex"])
    reflex["connections"][1]["name"] = "dive"
    return lamb(reflex=reflex, genome={"genes": GENES})
