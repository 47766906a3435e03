"""Worlds in which each number that can be an organism's own makes a difference within some ticks.

All numbers are sums of a few powers of two: they are the same in float32, in which organisms keep theirs.
"""

from typing import Any

GRASS: dict[str, Any] = {
    "count": 100,
    "body": {"radius": 0.25, "opaque": False},
    "metabolism": {"energy": 0.125, "energy_max": 0.5, "photosynthesis": 0.015625},
    "defence": {"toughness": 0.25, "poison": 0.0625, "cost": 0.5},
    "reproduction": {"kind": "spread", "rate": 0.25, "seed_rain": 0.015625, "spacing": 2.0},
}

BEAST: dict[str, Any] = {
    "count": 60,
    "sex": "none",
    "fertility": 0.75,
    "body": {"radius": 0.5, "mass": 2.0, "opaque": False},
    "properties": {"temperature": 310.0, "luminous_intensity": 2.0},
    "substances": {"salt": 0.5},
    "heat": {
        "specific_heat": 3500.0,
        "conductance": 16.0,
        "insulation": 0.125,
        "metabolic_heat": 4096.0,
        "regulate": {"set_point": 310.0, "warming": 64.0, "cooling": 64.0, "cost": 0.0000152587890625},
    },
    "metabolism": {"energy": 0.625, "energy_max": 1.0, "basal": 0.00390625, "handling_time": 2.0},
    "locomotion": {
        "speed": {"still": 0.0, "walk": 0.75},
        "cost": {"still": 0.0, "walk": 0.00390625},
        "turn": 0.75,
        "drag": 0.5,
    },
    "emits": {"musk": 1.0},
    "diet": [
        {"eats": "grass", "gain": 0.125, "efficiency": 0.5, "reach": 0.25, "chance": 0.5, "satiation": 0.875}
    ],
    "sensors": [
        {"kind": "own", "property": "energy"},
        {"kind": "nearest", "name": "eye", "target": "grass", "range": 5.0, "sight": 4.0, "blind": 0.5},
        {"kind": "smell", "name": "nose", "field": "musk", "at": [1.0, 0.5], "half_saturation": 0.5},
        {"kind": "gradient", "name": "trail", "field": "musk", "span": 1.0, "scale": 0.25},
        {
            "kind": "property",
            "name": "glow",
            "property": "luminous_intensity",
            "of": "beast",
            "range": 4.0,
            "zero": 1.0,
            "scale": 4.0,
        },
        {"kind": "approach", "name": "flow", "target": "beast", "range": 4.0, "scale": 0.5},
        {"kind": "temperature", "name": "skin", "zero": 256.0, "scale": 32.0},
        {"kind": "light", "name": "pit", "dark": 0.5},
    ],
    "actions": {"speed": ["still", "walk"], "turn": ["left", "none", "right"]},
    "happiness": {"weights": {"energy": -1.0}, "minimum": -0.75},
    "policy": {"kind": "individual", "hidden": [4], "learn": True},
    "ppo": {
        "horizon": 8,
        "epochs": 2,
        "learning_rate": 0.015625,
        "discount": 0.875,
        "entropy_coef": 0.015625,
        "gae_lambda": 0.875,
        "minibatch_size": 4,
        "clip": 0.0625,
        "clip_value": 0.0625,
        "value_weight": 0.5,
        "max_grad_norm": 0.25,
        "adam_epsilon": 0.00006103515625,
        "weight_decay": 0.125,
    },
    "reproduction": {
        "kind": "sexual",
        "energy_min": 0.5,
        "energy_given": 0.125,
        "age_min": 4.0,
        "reach": 1.0,
        "chance": 0.5,
        "consent": "none",
        "gestation": 4.0,
        "rest": 8.0,
        "father_rest": 4.0,
        "father_share": 0.5,
        "dispersal": 2.0,
        "spacing": 0.25,
    },
    "lethal": [
        {"property": "energy", "min": 0.0625},
        {"property": "temperature", "min": 300.0, "max": 330.0},
        {"property": "age", "max": 90.0},
    ],
}
ALONE = {
    "kind": "asexual",
    "rate": 0.25,
    "energy_min": 0.5,
    "energy_given": 0.125,
    "dispersal": 2.0,
    "spacing": 0.25,
}
GROWTH = {"rate": 0.0625, "newborn": 0.25, "cost": 0.015625, "reserve": 0.25}
KEPT = ("count", "properties", "metabolism", "sensors", "happiness", "policy", "ppo")
SWIMMER = {key: BEAST[key] for key in KEPT} | {
    "body": {"radius": 0.5, "opaque": False, "sinking": 0.125},
    "diet": [],
    "emits": {"musk": 1.0},
    "locomotion": BEAST["locomotion"] | {"climb": 0.5},
    "actions": BEAST["actions"] | {"climb": ["up", "none", "down"]},
    "default_action": {"climb": "none"},
}

FORAGER: dict[str, Any] = {
    "count": 40,
    "body": {"radius": 0.5, "opaque": False},
    "substances": {"sugar": 0.5, "air": 0.25, "salt": 0.5, "gas": 0.125},
    "metabolism": {"energy": 0.625, "energy_max": 2.0, "basal": 0.00390625},
    "reactions": [
        {
            "from": {"sugar": 1.0, "air": 0.5},
            "to": {"salt": 1.0},
            "energy": 0.001953125,
            "rate": 0.03125,
            "half": {"sugar": 0.5, "air": 0.25},
        }
    ],
    "exchange": [
        {
            "kind": "uptake",
            "field": "breeze",
            "rate": 0.0625,
            "half": 0.25,
            "concentration_max": 0.5,
            "at": [2.0, 1.0],
        },
        {"kind": "release", "substance": "salt", "field": "brine", "rate": 0.125, "above": 0.25},
        {"kind": "equilibrate", "field": "fumes", "rate": 0.25, "partition": 2.0},
    ],
    "emits": {"sweetness": {"substance": "sugar", "rate": 0.015625, "consume": True}},
    "diet": [{"eats": "grass", "gain": 0.125, "reach": 0.25, "assimilation": 0.5}],
    "carries": [{"object": "stone", "reach": 0.5, "cost": 0.0078125}],
    "builds": [{"object": "nest", "cost": 0.25, "spacing": 2.0}],
    "care": {"rate": 0.03125, "age_max": 8.0, "reach": 1.0, "reserve": 0.25, "efficiency": 0.5},
    "growth": {"rate": 0.0625, "newborn": 0.25, "pace": 0.5, "store": 0.5},
    "reproduction": {
        "kind": "asexual",
        "rate": 0.25,
        "energy_min": 0.5,
        "energy_given": 0.125,
        "dispersal": 2.0,
    },
    "locomotion": {"speed": {"still": 0.0, "walk": 0.75}, "cost": {"still": 0.0, "walk": 0.00390625}},
    "sensors": [
        {
            "kind": "rays",
            "name": "eyes",
            "targets": ["grass"],
            "count": 3,
            "fov": 1.5,
            "angle": 0.25,
            "range": 8.0,
        },
        {"kind": "nearest", "name": "eye", "target": "grass", "range": 8.0, "fov": 3.0},
        {
            "kind": "nearest",
            "name": "view",
            "target": "stone",
            "range": 8.0,
            "fov": 3.0,
            "occlusion": True,
            "at": [1.0, 0.5],
        },
    ],
    "actions": {"speed": ["still", "walk"], "turn": {"continuous": [-0.75, 0.5]}},
    "happiness": {"weights": {"eye_near": 1.0}, "minimum": -1.0},
    "policy": {"kind": "individual", "hidden": [4], "learn": False},
}
DRIFTER = {key: FORAGER[key] for key in ("count", "body", "metabolism", "sensors", "locomotion")} | {
    "actions": {"speed": ["walk"], "turn": {"continuous": [-0.75, 0.5]}},
    "always_on": ["walk"],
    "default_action": {"turn": 0.25},
    "reflex": {"connections": [{"sensor": "eye_near", "action": "turn", "weight": -1, "above": 0.875}]},
}
PEBBLE = {"body": {"radius": 0.25, "opaque": False}}
STONES: dict[str, Any] = {"objects": {"stone": PEBBLE | {"count": 100}}}
SHORE: dict[str, Any] = {
    "objects": STONES["objects"] | {"nest": PEBBLE},
    "substances": dict.fromkeys(("salt", "sugar", "air", "gas"), "in bodies and fields"),
    "fields": {
        "breeze": {"cell": 2.0, "substance": "air", "depth": 1.0, "initial": 0.25},
        "brine": {"cell": 2.0, "substance": "salt", "depth": 1.0, "initial": 0.25},
        "fumes": {"cell": 2.0, "substance": "gas", "depth": 1.0, "initial": 0.25},
        "sweetness": {"cell": 2.0, "diffusion": 0.5},
    },
    "species": {"grass": GRASS | {"substances": {"sugar": 0.5}}, "beast": FORAGER},
}


def world(beast: dict[str, Any], **more: Any) -> dict[str, Any]:
    """A world of grass and beasts."""
    return {
        "format": 1,
        "name": "own",
        "seed": 3,
        "space": {"size": [24.0, 24.0]},
        "ambient": {"temperature": 283.0},
        "fields": {"musk": {"cell": 2.0, "diffusion": 0.5, "decay": 0.125}},
        "substances": {"salt": "as of the sea"},
        "species": {"grass": GRASS, "beast": beast},
    } | more


WORLDS = {
    "meadow": world(BEAST),
    "desert": world(BEAST, ambient={"temperature": 320.0}),
    "division": world(BEAST | {"reproduction": ALONE, "growth": GROWTH}),
    "pond": world(SWIMMER, space={"size": [24.0, 24.0, 12.0]}),
    "dive": world(
        SWIMMER | {"locomotion": BEAST["locomotion"] | {"pitch": 0.5}}, space={"size": [24.0, 24.0, 12.0]}
    ),
    "shore": world(FORAGER, **SHORE),
    "drift": world(DRIFTER, **STONES),
    "winter": world(DRIFTER | {"ectothermy": {"q10": 2.0, "reference": 288.0, "torpor": 284.0}}, **STONES),
    "stroll": world(
        DRIFTER
        | {"actions": {"speed": ["walk"]}, "default_action": {}, "reflex": None, "wander": {"turn": 0.5}},
        **STONES,
    ),
}

ONLY = {  # what each world shows; the meadow shows all others
    "desert": ("heat.regulate.cooling", "lethal.temperature.max"),
    "division": ("reproduction.", "growth."),
    "pond": ("locomotion.climb", "body."),
    "dive": ("locomotion.pitch",),
    "shore": (
        "reactions.",
        "exchange.",
        "emits.sweetness",
        "diet.grass.assimilation",
        "carries.",
        "builds.",
        "care.",
        "growth.pace",
        "growth.store",
        "sensors.",
        "actions.",
        "metabolism.energy_max",
    ),
    "drift": ("default_action.", "actions.turn.continuous.0"),
    "winter": ("ectothermy.",),
    "stroll": ("wander.",),
}
