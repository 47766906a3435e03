"""Worlds that name code, one for each key whose field type accepts code, and the names that they use."""

from __future__ import annotations

import copy
from typing import Any

from pydantic import BaseModel

PAYLOAD = """
from pathlib import Path
Path({mark!r}).touch()
from ecs_eco import System, component, f32

class Wait(System):
    phase = "record"

    def process(self, *_):
        pass

@component
class Wool:
    length: f32 = 0.5  # [m]

def sense(world, table, seekers, out, first):
    out[:, first] = 0

def react(x):
    return x[:, :1] * 0

def feel(x):
    return x[:, 0] * 0

def act(x, uid):
    return x[:, :1] * 0

def flow(world, x, y, z):
    return x * 0, y * 0, z * 0

def mate(one, other):
    return one, other

def mutate(one):
    return one,

def net(n_observations, groups):
    from ecs_eco.learning import MLP
    return MLP(n_observations, groups)

def judge(series):
    return 1.0

def count(world):
    return world.tables["snail"].n
"""
"""A module that leaves a mark when it runs, with a function for each key."""

SNAIL: dict[str, Any] = {
    "count": 3,
    "body": {"radius": 0.1},
    "metabolism": {"energy": 0.5},
    "sensors": [{"kind": "own", "property": "energy"}],
    "actions": {"turn": ["left", "none"]},
    "locomotion": {"speed": {"still": 0.0}, "turn": 0.1},
    "genome": {
        "genes": [{"name": "g", "letters": 4, "low": 0.0, "high": 1.0}],
        "mutate": {"operator": "mutUniformInt", "indpb": 0.1},
    },
}

KEYS: dict[str, Any] = {  # a key for each pattern in ARGUMENTS, and its value; the module is `evil`
    "systems.*": ["evil:Wait"],
    "species.*.components.*": ["evil:Wool"],
    "species.*.sensors.*.function": [{"kind": "custom", "function": "evil:sense", "width": 1}],
    "species.*.reflex.function": {"function": "evil:react"},
    "species.*.happiness.function": {"function": "evil:feel", "minimum": 0.0},
    "species.*.policy.network": {"kind": "shared", "network": "evil:net"},
    "species.*.policy.function": {"kind": "function", "function": "evil:act"},
    "water.current_function": {"current_function": "evil:flow"},
    "species.*.genome.mate.operator": {"operator": "evil:mate"},
    "species.*.genome.mutate.operator": {"operator": "evil:mutate"},
    "reporters.*": {"snails": "evil:count"},
    "search.objective": "evil:judge",
    "search.objective.*.of": [{"of": "evil:judge", "weight": 1.0}],
}
PLACES = {
    "species.*.sensors.*.function": "sensors",
    "species.*.components.*": "components",
    "species.*.reflex.function": "reflex",
    "species.*.happiness.function": "happiness",
    "species.*.policy.network": "policy",
    "species.*.policy.function": "policy",
}
NAMES = (
    "os:system",
    "posix:system",
    "pydoc:pipepager",
    "builtins:exec",
    "builtins:eval",
    "subprocess:call",
    "runpy:run_path",
    "timeit:main",
    "importlib:import_module",
    "ctypes:CDLL",
    "pickle:loads",
    "evilpackage.inside:Wait",
    "evil.Wait:__init__",
    "ecs_eco.worlds.lamb.systems:np",
    "ecs_eco.inputs.code:builtins",
    "evil:",
    ":evil",
    "evil.py:Wait",
)
"""Names of unlisted code, apart from the names in the `evil` module."""


def world_of(pattern: str, **more: Any) -> dict[str, Any]:
    """Return a world that names code from the `evil` module at one key."""
    data: dict[str, Any] = {
        "format": 1,
        "name": "garden",
        "ticks": 20,
        "space": {"size": [9.0, 9.0]},
        "species": {"snail": copy.deepcopy(SNAIL)},
    } | more
    put(data, pattern, copy.deepcopy(KEYS[pattern]))
    if pattern.startswith("water"):
        data["space"] = {"size": [9.0, 9.0, 9.0]}
    return data


def put(data: dict[str, Any], pattern: str, value: Any) -> None:
    """Set the value of a key from the table KEYS in a snail world's data."""
    snail = data["species"]["snail"]
    if pattern in PLACES:
        snail[PLACES[pattern]] = value
        if pattern.endswith("network"):  # a species with a policy needs a reward
            snail["happiness"] = {"formula": "energy", "minimum": 0.0}
    elif ".genome." in pattern:
        snail["genome"][pattern.split(".")[3]] = value
    elif pattern in ("systems.*", "reporters.*"):
        data[pattern.removesuffix(".*")] = value
    elif pattern.startswith("water"):
        data["water"] = value
    else:
        data["search"] = {**data.get("search", {}), "objective": value}


def renamed(pattern: str, name: str, shell: str) -> Any:
    """Return a key's value in KEYS with this name instead of the one in `evil`, and with a shell command
    where the value allows one."""

    def inside(value: Any) -> Any:
        if isinstance(value, dict):
            return {k: inside(v) for k, v in value.items()}
        if isinstance(value, list):
            return [inside(v) for v in value]
        return name if isinstance(value, str) and value.startswith("evil:") else value

    value = inside(copy.deepcopy(KEYS[pattern]))
    return value | {"cmd": shell, "command": shell} if pattern.endswith("operator") else value


def models(model: type[BaseModel], seen: set[type]) -> set[type]:
    """Return all models reachable from a model."""

    def inside(annotation: Any) -> None:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            models(annotation, seen)
        for part in getattr(annotation, "__args__", ()):
            inside(part)

    if model not in seen:
        seen.add(model)
        for field in model.model_fields.values():
            inside(field.annotation)
    return seen


def fields_that_name_code() -> set[str]:
    """Return the names of all world fields that may name code, derived from their types."""
    from ecs_eco.config import WorldConfig
    from ecs_eco.config.names import fields_of

    return {name for model in models(WorldConfig, set()) for name in fields_of(model)}
