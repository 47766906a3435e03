"""A world, and what may be wrong in it: where, what is written, and what the refusal says."""

from __future__ import annotations

import re

WORLD = """\
format = 1
name = "meadow"
ticks = 10
dt = 1.0
[space]
size = [40.0, 30.0]
edges = "torus"
[substances]
glucose = "blood sugar"
[fields.smoke]
cell = 2.0
diffusion = 0.5
decay = 0.1
[objects.stone]
count = 3
body = { radius = 0.5 }
[species.grass]
count = 90
body = { radius = 0.2 }
emits = { smoke = 0.1 }
reproduction = { kind = "spread", rate = 0.1, spacing = 1.0 }
[species.goat]
count = 10
body = { radius = 0.4, mass = 30.0 }
substances = { glucose = 0.005 }
metabolism = { energy = 0.5, energy_max = 1.0, basal = 0.01 }
diet = [{ eats = "grass", gain = 0.1, chance = 0.5 }]
locomotion = { speed = { still = 0.0, walk = 0.5 }, cost = { walk = 0.01 }, turn = 0.5 }
sensors = [
  { kind = "own", property = "energy" },
  { kind = "nearest", target = "grass", range = 5.0 },
  { kind = "smell", field = "smoke", at = [1.0, 0.0] },
  { kind = "touch", target = "stone" },
  { kind = "rays", count = 3, range = 4.0, targets = ["grass", "wall"] },
  { kind = "property", property = "fertility", of = "goat", range = 3.0 },
]
actions = { speed = ["still", "walk"], turn = ["left", "none", "right"], eat = ["eat"] }
default_action = { speed = "still", turn = "none" }
always_on = ["eat"]
happiness = { formula = "energy - 0.1 * smoke", minimum = -1.0 }
reflex = { connections = [{ sensor = "touch_stone", action = "walk", weight = -1, above = 0.5 }] }
policy = { kind = "shared", hidden = [8] }
ppo = { horizon = 16 }
reproduction = { kind = "asexual", place = "anywhere", rate = 0.01, energy_min = 0.6, energy_given = 0.3 }
lethal = [{ property = "energy", min = 0.0, cause_below = "starved" }]
"""

# what stands there, what is written instead; key (goat is species.goat), value,
# part of what is allowed, right name
CASES: dict[str, tuple[str, str, str, str, str, str]] = {
    "food": ('eats = "grass"', 'eats = "gras"', "goat.diet.0.eats", '"gras"', "grass, goat, stone", "grass"),
    "target": ('target = "grass"', 'target = "grss"', "goat.sensors.1.target", '"grss"', "goat", "grass"),
    "touch": (
        'target = "stone"',
        'target = "stoen"',
        "goat.sensors.3.target",
        '"stoen"',
        "wall, any",
        "stone",
    ),
    "ray": ('"wall"]', '"wal"]', "goat.sensors.4.targets.1", '"wal"', "wall", "wall"),
    "whose": ('of = "goat"', 'of = "gaot"', "goat.sensors.5.of", '"gaot"', "grass, goat, stone", "goat"),
    "of whom": (
        'of = "goat"',
        'of = ["stone", "goat"]',
        "goat.sensors.5.property",
        '"fertility"',
        "mass, radius, volume",
        "",
    ),
    "what of it": (
        'property = "fertility", of',
        'property = "fertlity", of',
        "goat.sensors.5.property",
        '"fertlity"',
        "glucose",
        "fertility",
    ),
    "smell": ('field = "smoke"', 'field = "smok"', "goat.sensors.2.field", '"smok"', "smoke", "smoke"),
    "emits": ("{ smoke = 0.1 }", "{ smole = 0.1 }", "grass.emits.smole", '"smole"', "smoke", "smoke"),
    "property": (
        'property = "energy" }',
        'property = "enrgy" }',
        "goat.sensors.0.property",
        '"enrgy"',
        "energy, age, fertility, glucose",
        "energy",
    ),
    "lethal": (
        'property = "energy", min',
        'property = "glucos", min',
        "goat.lethal.0.property",
        '"glucos"',
        "glucose",
        "glucose",
    ),
    "substance": (
        "{ glucose = 0.005",
        "{ glucosse = 0.005",
        "goat.substances.glucosse",
        '"glucosse"',
        "glucose",
        "glucose",
    ),
    "physical": (
        "substances = { glucose",
        "properties = { temprature = 3.0 }\nsubstances = { glucose",
        "goat.properties.temprature",
        '"temprature"',
        "temperature, pressure",
        "temperature",
    ),
    "group": ("actions = { speed", "actions = { sped", "goat.actions.sped", '"sped"', "speed, turn", "speed"),
    "turn": (
        '"none", "right"',
        '"none", "rigth"',
        "goat.actions.turn.2",
        '"rigth"',
        "left, none, right",
        "right",
    ),
    "gait": (
        '["still", "walk"]',
        '["still", "wakl"]',
        "goat.actions.speed.1",
        '"wakl"',
        "still, walk",
        "walk",
    ),
    "twice": (
        '["still", "walk"]',
        '["still", "walk", "walk"]',
        "goat.actions.speed.2",
        '"walk"',
        "still, walk",
        "",
    ),
    "cost": ("cost = { walk", "cost = { wlk", "goat.locomotion.cost.wlk", '"wlk"', "still, walk", "walk"),
    "neutral": (
        'default_action = { speed = "still"',
        'default_action = { speed = "stil"',
        "goat.default_action.speed",
        '"stil"',
        "still, walk",
        "still",
    ),
    "automatic": ('always_on = ["eat"]', 'always_on = ["eta"]', "goat.always_on.0", '"eta"', "eat", "eat"),
    "chosen": (
        'always_on = ["eat"]',
        'always_on = ["walk"]',
        "goat.always_on.0",
        '"walk"',
        "the only action of its group",
        "",
    ),
    "reflex sensor": (
        'sensor = "touch_stone"',
        'sensor = "touch_ston"',
        "goat.reflex.connections.0.sensor",
        '"touch_ston"',
        "touch_stone",
        "touch_stone",
    ),
    "reflex action": (
        'action = "walk"',
        'action = "wlak"',
        "goat.reflex.connections.0.action",
        '"wlak"',
        "speed.walk",
        "walk",
    ),
    "weight": ("weight = -1", "weight = 2", "goat.reflex.connections.0.weight", "2", "-1, 0, 1", ""),
    "thresholds": (
        "above = 0.5",
        "above = 0.5, below = 0.1",
        "goat.reflex.connections.0",
        "{",
        "exactly one",
        "",
    ),
    "formula name": (
        "0.1 * smoke",
        "0.1 * smke",
        "goat.happiness.formula",
        '"energy - 0.1 * smke"',
        "smoke",
        "smoke",
    ),
    "formula syntax": (
        "0.1 * smoke",
        "0.1 *",
        "goat.happiness.formula",
        '"energy - 0.1 *"',
        "numbers, names",
        "",
    ),
    "formula unsafe": ("0.1 * smoke", "smoke.__class__", "goat.happiness.formula", "__class__", "abs", ""),
    "formula call": ("0.1 * smoke", "sqr(smoke)", "goat.happiness.formula", "sqr", "sqrt", "sqrt"),
    "minimum": (", minimum = -1.0", "", "goat.happiness.minimum", "", "finite number", ""),
    "two ways": (
        "minimum = -1.0",
        "minimum = -1.0, weights = { energy = 1.0 }",
        "goat.happiness",
        "{",
        "exactly one",
        "",
    ),
    "function": (
        'formula = "energy - 0.1 * smoke"',
        'function = "math:sqr"',
        "goat.happiness.function",
        '"math:sqr"',
        "code = [",
        "",
    ),
    "module": (
        'formula = "energy - 0.1 * smoke"',
        'function = "no_such_module:f"',
        "goat.happiness.function",
        '"no_such_module:f"',
        "code = [",
        "",
    ),
    "kind": ('kind = "touch"', 'kind = "tuch"', "goat.sensors.3.kind", '"tuch"', "own, nearest", "touch"),
    "no kind": ('kind = "touch", ', "", "goat.sensors.3.kind", "", "own, nearest", ""),
    "reproduction": (
        'kind = "asexual"',
        'kind = "asexul"',
        "goat.reproduction.kind",
        '"asexul"',
        "asexual, spread, sexual",
        "asexual",
    ),
    "rate": ("rate = 0.01", "rate = -0.01", "goat.reproduction.rate", "-0.01", "at least 0", ""),
    "basal": ("basal = 0.01", "basal = -1", "goat.metabolism.basal", "-1", "at least 0", ""),
    "often": ("rate = 0.01", "rate = 2.0", "goat.reproduction.rate", "2.0", "at most 1 per second", ""),
    "chance": ("chance = 0.5", "chance = 1.5", "goat.diet.0.chance", "1.5", "at most 1", ""),
    "nan": ("basal = 0.01", "basal = nan", "goat.metabolism.basal", "nan", "finite", ""),
    "infinite": ("gain = 0.1", "gain = inf", "goat.diet.0.gain", "inf", "finite", ""),
    "text": ("count = 10", 'count = "10"', "goat.count", '"10"', "whole number", ""),
    "fraction": ("count = 10", "count = 10.5", "goat.count", "10.5", "whole number", ""),
    "true": ("dt = 1.0", "dt = true", "dt", "true", "number", ""),
    "zero dt": ("dt = 1.0", "dt = 0", "dt", "0", "more than 0", ""),
    "fewer than no goats": ("count = 10\n", "count = -1\n", "goat.count", "-1", "at least 0", ""),
    "no count": ("count = 10\n", "\n", "goat.count", "", "whole number", ""),
    "no species": (
        WORLD[WORLD.index("[species.grass]") :],
        "[species]",
        "species",
        "{}",
        "at least 1 entries",
        "",
    ),
    "no stones": ("count = 3\n", "count = 0\n", "objects.stone.count", "0", "at least 1", ""),
    "range": ("range = 5.0", "range = 16.0", "goat.sensors.1.range", "16.0", "at most 15 m", ""),
    "cell": ("cell = 2.0", "cell = 20.0", "fields.smoke.cell", "20.0", "at most 15 m", ""),
    "tiny cell": ("cell = 2.0", "cell = 1e-6", "fields.smoke.cell", "1e-6", "cells", ""),
    "body": ("radius = 0.4", "radius = 40.0", "goat.body.radius", "40.0", "at most 15 m", ""),
    "size": ("size = [40.0, 30.0]", "size = [40.0]", "space.size", "[40.0]", "at least 2 entries", ""),
    "edges": ('edges = "torus"', 'edges = "tours"', "space.edges", '"tours"', "torus, walls", "torus"),
    "key": ("basal = 0.01", "bassal = 0.01", "goat.metabolism.bassal", "0.01", "energy_max", "basal"),
    "section": ("[substances]", "[substance]", "substance", "{", "fields, objects", "substances"),
    "format": ("format = 1", "format = 2", "format", "2", "1", ""),
    "name": ('name = "meadow"', 'name = "my meadow"', "name", '"my meadow"', "text that matches", ""),
    "color": ("count = 10\n", 'count = 10\ncolor = "red"\n', "goat.color", '"red"', "#rrggbb", ""),
    "hyperparameter": (
        "horizon = 16",
        "horizn = 16",
        "goat.ppo.horizn",
        "16",
        "horizon, learning_rate",
        "horizon",
    ),
    "horizon": ("horizon = 16", "horizon = -1", "goat.ppo.horizon", "-1", ">= 1", ""),
    "max count": ("count = 10\n", "count = 10\nmax_count = 5\n", "goat.count", "10", "at most 5", ""),
    "energy": ("energy = 0.5", "energy = 1.5", "goat.metabolism.energy", "1.5", "at most energy_max", ""),
    "given": (
        "energy_given = 0.3",
        "energy_given = 0.8",
        "goat.reproduction.energy_given",
        "0.8",
        "energy_min",
        "",
    ),
    "spacing": ("spacing = 1.0", "spacing = 9.0", "grass.reproduction.spacing", "9.0", "smaller spacing", ""),
    "near": ("spacing = 1.0", 'spacing = 1.0, place = "near"', "grass.reproduction.dispersal", "", "[m]", ""),
    "min max": ("min = 0.0", "min = 1.0, max = 0.9", "goat.lethal.0.min", "1.0", "less than 0.9", ""),
    "born dead": ("min = 0.0", "min = 0.5", "goat.lethal.0.min", "0.5", "around the value at birth", ""),
    "same name": (
        '{ kind = "touch"',
        '{ name = "energy", kind = "touch"',
        "goat.sensors.3.name",
        '"energy"',
        "a unique name",
        "",
    ),
    "mean's name": (
        '{ kind = "touch"',
        '{ name = "smoke", kind = "touch"',
        "goat.sensors.3.name",
        '"smoke"',
        "name",
        "",
    ),
    "two kinds": ("[objects.stone]", "[objects.goat]", "objects.goat", '"goat"', "a unique name", ""),
    "bad name": ("[objects.stone]", '[objects."a stone"]', "objects.a stone", "", "a letter, then", ""),
    "policy file": (
        "hidden = [8]",
        'hidden = [8], file = "goad.safetensors"',
        "goat.policy.file",
        '"goad.safetensors"',
        "next to the world file",
        "goat.safetensors",
    ),
    "remains": ("count = 10\n", 'count = 10\nremains = "stne"\n', "goat.remains", '"stne"', "stone", "stone"),
    "policy of none": ("count = 90", "count = 90\nppo = { horizon = 3 }", "grass.ppo", "{", "shared", ""),
    "learning without a network": (
        'policy = { kind = "shared", hidden = [8] }\nppo = { horizon = 16 }',
        'policy = { kind = "external", learn = true }',
        "goat.policy.learn",
        "true",
        "shared",
        "",
    ),
    "hyperparameters of outsiders": (
        'policy = { kind = "shared", hidden = [8] }',
        'policy = { kind = "external" }',
        "goat.ppo",
        "{",
        "shared",
        "",
    ),
    "no function": (
        'policy = { kind = "shared", hidden = [8] }\nppo = { horizon = 16 }',
        'policy = { kind = "function" }',
        "goat.policy.function",
        "",
        "module:name",
        "",
    ),
    "training": (
        "[species.grass]",
        '[training]\nset = { "species.goat.count" = -3 }\n[species.grass]',
        'training.set."species.goat.count"',
        "-3",
        "at least 0",
        "",
    ),
}

FOLLOWED = {  # mistakes that break what others name
    *("two kinds", "bad name")
}
for case, row in CASES.items():
    CASES[case] = (*row[:2], re.sub("^(goat|grass)(?=[.]|$)", r"species.\1", row[2]), *row[3:])
