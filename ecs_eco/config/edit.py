"""Change values in a world file's text, leaving the rest unchanged, or write a world as new TOML."""

import json
import tomllib
from collections.abc import Mapping
from typing import Any

from ecs_eco.config.document import present
from ecs_eco.config.explain import value_at
from ecs_eco.config.former import both_names
from ecs_eco.config.lines import value_spans
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.ranges import take_ranges
from ecs_eco.config.rules import Key
from ecs_eco.engine.errors import MISSING


def edited(text: str, values: Mapping[Key, Any]) -> str | None:
    """Return the text with these values, keeping ranges next to numbers; None if that is impossible."""
    try:
        for key, value in values.items():
            text = _put(text, key, value)
        data = present(tomllib.loads(text))
    except tomllib.TOMLDecodeError:
        return None
    take_ranges(data)
    right = all(value_at(data, key) == value for key, value in values.items())
    return text if right else None


def _put(text: str, key: Key, value: object) -> str:
    data = present(tomllib.loads(text))
    spans = {both_names(at, data, WorldConfig)[0]: span for at, span in value_spans(text).items()}
    if (*key, "value") in spans and (*key, "search") in spans:
        key = (*key, "value")
    if key in spans:
        begin, end = spans[key]
        return text[:begin] + literal(value) + text[end:]
    held = max((k for k in spans if k == key[: len(k)]), key=len, default=())
    name = ".".join(_bare(str(part)) for part in key[len(held) :])
    if not held:
        return f"{name} = {literal(value)}\n{text}"
    begin, end = spans[held]
    if text[begin] == "{":
        comma = "" if text[begin + 1 : end - 1].strip() == "" else ", "
        return f"{text[: end - 1].rstrip()}{comma}{name} = {literal(value)} {text[end - 1 :]}"
    line = text.find("\n", end)
    line = len(text) if line < 0 else line
    return f"{text[:line]}\n{name} = {literal(value)}{text[line:]}"


def literal(value: object) -> str:
    """Return a value as TOML, with inline tables."""
    if isinstance(value, Mapping):
        return (
            "{ "
            + ", ".join(f"{_bare(str(k))} = {literal(v)}" for k, v in value.items() if v is not None)
            + " }"
        )
    if isinstance(value, list | tuple):
        return "[" + ", ".join(literal(v) for v in value if v is not None) + "]"
    if isinstance(value, float) and value == value and abs(value) != float("inf"):
        return repr(value)
    return json.dumps(value, ensure_ascii=False)


def _bare(name: str) -> str:
    return name if name.isascii() and name.replace("_", "").replace("-", "").isalnum() else json.dumps(name)


def as_toml(data: Mapping[str, Any]) -> str:
    """Return a world as TOML, without null values."""
    plain = {k: v for k, v in data.items() if not isinstance(v, Mapping)}
    lines = [f"{k} = {literal(v)}" for k, v in plain.items() if v is not None]
    for name, part in data.items():
        if isinstance(part, Mapping) and part is not MISSING:
            lines += _section((name,), part)
    return "\n".join(lines) + "\n"


def _section(key: Key, part: Mapping[str, Any]) -> list[str]:
    """Return a table under its header; in species, objects and fields, each entry has its own header."""
    head = ".".join(_bare(str(k)) for k in key)
    if len(key) == 1 and key[0] in ("species", "objects", "fields"):
        return [line for name, inner in part.items() for line in _section((*key, name), inner)]
    return ["", f"[{head}]", *(f"{_bare(str(k))} = {literal(v)}" for k, v in part.items() if v is not None)]
