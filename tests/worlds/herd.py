"""A herd with genes for everything, which reproduces sexually and learns one by one."""

import copy

import numpy as np

from ecs_eco import component, f32

F = np.float32


@component
class Wool:
    """The coat of one animal."""

    length: f32 = 0.01  # [m]


def gene_for(name, trait=None, letters=3, **more):
    return {"name": name, "trait": trait, "letters": letters} | (more or {"low": 0.0, "high": 1.0})


HERD = {
    "format": 1,
    "name": "herd",
    "seed": 5,
    "space": {"size": [30.0, 30.0]},
    "fields": {"musk": {"cell": 2.0, "diffusion": 0.5, "decay": 0.1}},
    "species": {
        "grass": {
            "count": 120,
            "body": {"radius": 0.3, "opaque": False},
            "metabolism": {"energy": 0.1, "energy_max": 0.4, "photosynthesis": 0.01},
            "defence": {"cost": 0.5},
            "reproduction": {"kind": "spread", "rate": 0.1, "seed_rain": 0.01, "spacing": 2.0},
            "genome": {
                "alphabet": "01",
                "mutate": {"operator": "mutFlipBit", "indpb": 0.02},
                "genes": [
                    gene_for("vigour", "metabolism.photosynthesis", low=0.0, high=0.02),
                    gene_for("runner", "reproduction.spread", low=0.2, high=1.0),
                    gene_for("thorn", "defence.toughness", low=0.0, high=0.7),
                    gene_for("venom", "defence.poison", low=0.0, high=0.07),
                ],
            },
        },
        "goat": {
            "count": 60,
            "sex": "random",
            "body": {"radius": 0.4, "mass": 50.0},
            "properties": {"temperature": 311.0},
            "heat": {"insulation": 0.1, "metabolic_heat": 5000.0},
            "metabolism": {"energy": 0.6, "basal": 0.004},
            "locomotion": {"speed": {"still": 0.0, "walk": 0.8}, "cost": {"walk": 0.004}, "turn": 0.8},
            "emits": {"musk": 1.0},
            "diet": [{"eats": "grass", "gain": 0.2}],
            "sensors": [
                {"kind": "own", "property": "energy"},
                {"kind": "nearest", "target": "grass", "range": 5.0},
                {"kind": "smell", "field": "musk", "at": [1.0, 0.5]},
            ],
            "actions": {
                "speed": ["still", "walk"],
                "turn": ["left", "none", "right"],
                "eat": ["eat"],
                "mate": ["mate"],
            },
            "default_action": {"speed": "still", "turn": "none"},
            "reflex": {
                "connections": [
                    {"name": "green", "sensor": "grass_near", "action": "eat", "weight": 0, "above": 0.8},
                    {"sensor": "energy", "action": "walk", "weight": 1, "below": 0.1},
                ]
            },
            "happiness": {"weights": {"energy": 1.0, "musk": 0.1}, "minimum": -1.0},
            "policy": {
                "kind": "individual",
                "hidden": [6],
                "learn": True,
                "inherit": "learned",
                "mutation_sd": 0.02,
            },
            "ppo": {"horizon": 8, "epochs": 2, "learning_rate": 0.01},
            "components": [Wool],
            "genome": {
                "mutate": {"operator": "mutUniformInt", "indpb": 0.01},
                "genes": [
                    gene_for("green", "reflex.green.weight", 1, values=[0, 0, 0, -1]),
                    gene_for("blue", None, 1, values=[0, 0, 0, 1]),
                    gene_for("edge", "reflex.green.threshold", low=0.5, high=0.9),
                    gene_for("size", "body.radius", low=0.2, high=0.6),
                    gene_for("weight", "body.mass", low=20.0, high=80.0),
                    gene_for("legs", "locomotion.pace", low=0.5, high=2.0),
                    gene_for("eye", "sensors.grass.range", low=1.0, high=6.0),
                    gene_for("nose", "sensors.musk.left", low=-1.0, high=1.0),
                    gene_for("joy", "happiness.energy", low=-1.0, high=2.0),
                    gene_for("span", "life.age_max", low=40.0, high=90.0),
                    gene_for("rate", "ppo.learning_rate", low=1e-3, high=0.1, scale="log"),
                    gene_for("young", "reproduction.litter", 1, values=[1, 1, 2, 3]),
                    gene_for("ripe", "reproduction.age_min", low=5.0, high=20.0),
                    gene_for("wool", "Wool.length", low=0.0, high=0.1),
                    gene_for("coat", "heat.insulation", low=0.0, high=0.5),
                ],
            },
            "reproduction": {
                "kind": "sexual",
                "energy_min": 0.5,
                "energy_given": 0.15,
                "age_min": 10.0,
                "reach": 1.5,
                "consent": "one",
                "gestation": 4.0,
                "rest": 3.0,
                "father_share": 0.25,
            },
            "lethal": [
                {"property": "energy", "min": 0.0, "cause_below": "starved"},
                {"property": "age", "max": 70.0, "cause_above": "too old"},
            ],
        },
    },
}


def herd(**goat):
    config = copy.deepcopy(HERD)
    config["species"]["goat"] |= goat
    return config


def goats(world):
    table = world.tables["goat"]
    return table, table.by_uid()
