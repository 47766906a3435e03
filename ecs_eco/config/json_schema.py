"""The JSON schema of world files, which lets editors complete keys, explain them and mark errors."""

from dataclasses import fields
from typing import Any

from ecs_eco.config.models.world import WorldConfig
from ecs_eco.learning.aliases import ALIASES
from ecs_eco.learning.settings import PPO

PLAIN = ("Search", "Goal", "Confirm", "Range")  # sections whose numbers have no range
RANGED: dict[str, Any] = {  # a value, and the range that `ecs-eco search` explores
    "properties": {
        "value": {"type": "number", "description": "the value that runs use"},
        "search": {
            "type": "array",
            "items": {"type": "number"},
            "minItems": 2,
            "maxItems": 2,
            "description": "[low, high]",
        },
        "scale": {
            "enum": ["linear", "log"],
            "default": "linear",
            "description": "whether equal steps are equal differences or equal ratios",
        },
    },
    "required": ["value", "search"],
    "additionalProperties": False,
}
TYPES = {"int": "integer", "float": "number", "bool": "boolean"}


def json_schema(model: type[WorldConfig] = WorldConfig) -> dict[str, Any]:
    """Return the schema (JSON Schema 2020-12) of a world file: every key with its description, `unit`,
    default and limits. `model` is the class of a loaded world, which can have custom features.

    It limits only single values; `ecs-eco check` also checks that values are consistent.
    """
    schema = _without_null(model.model_json_schema(by_alias=False))
    sections = {name: part if name in PLAIN else _ranged(part) for name, part in schema["$defs"].items()}
    schema = {
        **_ranged({k: v for k, v in schema.items() if k != "$defs"}),
        "$defs": {**sections, "Ranged": RANGED},
    }
    ranges = schema["$defs"]["Search"]["properties"]["ranges"]
    ranges["additionalProperties"] = {
        "anyOf": [RANGED["properties"]["search"], ranges["additionalProperties"]]
    }
    schema["$defs"]["Species"]["properties"]["ppo"] |= {
        "properties": _hyperparameters(),
        "additionalProperties": False,
    }
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "World file of ecs-eco"}
    return head | {key: value for key, value in schema.items() if key not in head}


def _hyperparameters() -> dict[str, Any]:
    """Return the schema of PPO's fields, which PPO validates itself."""
    properties = {}
    for f in fields(PPO):
        low, high, kind = f.metadata["low"], f.metadata["high"], TYPES[str(f.type)]
        limits: dict[str, Any] = {}
        if kind != "boolean":
            limits = {"exclusiveMinimum" if f.metadata["above"] else "minimum": low} | (
                {"maximum": high} if high < float("inf") else {}
            )
        properties[f.name] = {"type": kind, "description": f.metadata["doc"], "default": f.default, **limits}
    others = {
        word: properties[name] | {"description": f"another name for {name}"} for word, name in ALIASES.items()
    }
    return properties | others


def _ranged(node: object) -> Any:
    """Return the schema in which any number can have a range next to it."""
    if isinstance(node, list):
        return [_ranged(x) for x in node]
    if not isinstance(node, dict):
        return node
    if node.get("type") in ("number", "integer") and "const" not in node:
        # this reference limits only tables
        return node | {"type": [node["type"], "object"], "$ref": "#/$defs/Ranged"}
    return {key: _ranged(value) for key, value in node.items()}


def _without_null(node: object) -> Any:
    """Return the schema without null, which TOML lacks; keys of named tables must be names."""
    if isinstance(node, list):
        return [_without_null(x) for x in node]
    if not isinstance(node, dict):
        return node
    node = {
        key: _without_null(value) for key, value in node.items() if not (key == "default" and value is None)
    }
    kinds = node.get("anyOf")
    if isinstance(kinds, list) and {"type": "null"} in kinds:
        kinds = [kind for kind in kinds if kind != {"type": "null"}]
        rest = {key: value for key, value in node.items() if key != "anyOf"}
        node = {**kinds[0], **rest} if len(kinds) == 1 else {**rest, "anyOf": kinds}
    if "patternProperties" in node:
        node.setdefault("additionalProperties", False)
    return node
