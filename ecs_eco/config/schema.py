"""The JSON schema of world files, by which editors complete keys, say what they mean and mark what is wrong."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from ecs_eco.config.world import WorldConfig

TYPES = {"int": "integer", "float": "number", "bool": "boolean"}


def json_schema() -> dict[str, Any]:
    """The schema (JSON Schema 2020-12) of a world file: every key with its description, `unit`, default and limits.

    It says what single values may be; what must fit together only `ecs-eco check` finds.
    """
    schema = _without_null(WorldConfig.model_json_schema())
    schema["$defs"]["Species"]["properties"]["ppo"] |= {"properties": _hyperparameters(), "additionalProperties": False}
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "World file of ecs-eco"}
    return head | {key: value for key, value in schema.items() if key not in head}


def _hyperparameters() -> dict[str, Any]:
    """The fields of PPO, which check themselves."""
    from ecs_eco.learning import PPO

    found = {}
    for f in fields(PPO):
        low, high, kind = f.metadata["low"], f.metadata["high"], TYPES[str(f.type)]
        limits: dict[str, Any] = {}
        if kind != "boolean":
            limits = {"exclusiveMinimum" if f.metadata["above"] else "minimum": low} | ({"maximum": high} if high < float("inf") else {})
        found[f.name] = {"type": kind, "description": f.metadata["doc"], "default": f.default, **limits}
    return found


def _without_null(node: Any) -> Any:
    """The schema without null, which TOML does not have: a key may be left out instead; names alone are keys of named tables."""
    if isinstance(node, list):
        return [_without_null(x) for x in node]
    if not isinstance(node, dict):
        return node
    node = {key: _without_null(value) for key, value in node.items() if not (key == "default" and value is None)}
    kinds = node.get("anyOf")
    if isinstance(kinds, list) and {"type": "null"} in kinds:
        kinds = [kind for kind in kinds if kind != {"type": "null"}]
        rest = {key: value for key, value in node.items() if key != "anyOf"}
        node = {**kinds[0], **rest} if len(kinds) == 1 else {**rest, "anyOf": kinds}
    if "patternProperties" in node:
        node.setdefault("additionalProperties", False)
    return node
