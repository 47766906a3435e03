"""Write the reference of the world file into docs/reference/worlds.md, from the models that check it;
--check: only compare.

Each section becomes a table of its keys, with type, unit and default, between the two marks in the page.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import sys
import types
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from ecs_eco.config.formula import ALLOWED
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.inputs.section import Function, Section
from ecs_eco.learning import PPO

PAGE = Path(__file__).parents[1] / "docs" / "reference" / "worlds.md"
MARKS = ("<!-- reference: written by tools/make_reference.py -->", "<!-- end of reference -->")
WORDS = {float: "number", int: "whole number", bool: "true or false", str: "text"}
SIGNS = {"gt": ">", "ge": "≥", "lt": "<", "le": "≤"}
HEAD = "| key | takes | unit | default | |\n|---|---|---|---|---|\n"


def reference() -> str:
    """All sections, in the order in which the file names them."""
    paths: dict[type[Section], list[str]] = {}
    for model, path in _sections(WorldConfig, ""):
        paths.setdefault(model, []).append(path)
    tables = [_table(model, keys) for model, keys in paths.items()]
    return "\n\n".join(
        [*tables, _ppo(), f"### Formulas\n\nA formula is made of {ALLOWED}. What is true is 1."]
    )


def _sections(model: type[Section], path: str) -> Iterator[tuple[type[Section], str]]:
    """A section, and those within."""
    yield model, path
    for name, info in model.model_fields.items():
        for inner, around in _models(info.annotation):
            yield from _sections(inner, f"{path}.{name}{around}".lstrip("."))


def _table(model: type[Section], paths: list[str]) -> str:
    kind = _kind(model)
    title = (
        ", ".join(f"`{p}`" for p in paths if p) + (f', `kind = "{kind}"`' if kind else "")
        or "The top of the file"
    )
    rows = [_row(n, f) for n, f in model.model_fields.items() if n != "kind" or not kind]
    return f"### {title}\n\n{' '.join((model.__doc__ or '').split())}\n\n{HEAD}" + "\n".join(rows)


def _kind(model: type[Section]) -> str:
    info = model.model_fields.get("kind")
    choices = typing.get_args(info.annotation) if info else ()
    return choices[0] if len(choices) == 1 else ""


def _models(kind: Any, around: str = "") -> Iterator[tuple[type[Section], str]]:
    """The sections that a type holds, each with what stands between: .NAME in a table of them, [] in a list."""
    if isinstance(kind, type) and issubclass(kind, Section):
        yield kind, around
        return
    origin = typing.get_origin(kind)
    between = {dict: ".NAME", list: "[]"}.get(origin, "") if isinstance(origin, type) else ""
    for part in typing.get_args(kind):
        yield from _models(part, around + between)


def _row(name: str, info: FieldInfo) -> str:
    unit = (info.json_schema_extra or {}).get("unit", "") if isinstance(info.json_schema_extra, dict) else ""
    text = (info.description or "").removesuffix(f" [{unit}]")
    takes = _words(info.annotation, tuple(info.metadata))
    return f"| `{name}` | {takes} | {'' if unit == '1' else unit} | {_default(info)} | {text} |".replace(
        "|  |", "| |"
    )


def _default(info: FieldInfo) -> str:
    if info.is_required():
        return "needed"
    value = info.default_factory() if info.default_factory else info.default  # type: ignore[call-arg]
    if value is None or value is PydanticUndefined:
        return "absent"
    return "" if isinstance(value, Section) else f"`{_toml(value)}`"


def _toml(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        known = {math.pi: "3.14159…", -math.pi: "-3.14159…", 2 * math.pi: "6.28318…"}
        return known.get(value, f"{value:g}")
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return {"{}": "{ }"}.get(str(value), f'"{value}"' if isinstance(value, str) else str(value))


def _words(kind: Any, metadata: tuple[Any, ...] = ()) -> str:
    """A type in words, with its limits."""
    origin, parts = typing.get_origin(kind), typing.get_args(kind)
    if kind == Function or any(m in Function.__metadata__ for m in metadata):
        return "`module:name`"
    if origin is typing.Annotated:
        return _words(parts[0], parts[1:])
    if origin is typing.Literal:
        return ", ".join(f"`{_toml(p)}`" for p in parts)
    if origin in (types.UnionType, typing.Union):
        words = dict.fromkeys(_words(p, metadata) for p in parts if p is not type(None))
        return " or ".join(words)
    if origin is list:
        return f"list{_length(metadata)}: {_words(parts[0])}"
    if origin is dict:
        return f"table: {_words(parts[1])}"
    if isinstance(kind, type) and issubclass(kind, Section):
        return "see below"
    return WORDS.get(kind, "any value") + _limits(metadata)


def _limits(metadata: tuple[Any, ...]) -> str:
    """ " > 0" and the like; what only keeps numbers finite, and lists in memory, is left out."""
    limits = [(sign, getattr(m, name, None)) for m in _flat(metadata) for name, sign in SIGNS.items()]
    return ",".join(
        f" {sign} {_toml(limit)}" for sign, limit in limits if limit is not None and abs(limit) < 1e6
    )


def _length(metadata: tuple[Any, ...]) -> str:
    low, high = (
        next((v for m in _flat(metadata) if (v := getattr(m, n, None)) is not None), None)
        for n in ("min_length", "max_length")
    )
    if low is None:
        return ""
    return f" of {low}" if low == high else f" of {low} or more" if high is None else f" of {low} to {high}"


def _flat(metadata: tuple[Any, ...]) -> list[Any]:
    """What limits a type, also where pydantic wrapped it."""
    return [inner for m in metadata for inner in getattr(m, "metadata", (m,))]


def _ppo() -> str:
    rows = [f"| `{f.name}` | `{_toml(f.default)}` | {f.metadata['doc']} |" for f in dataclasses.fields(PPO)]
    return (
        "### `species.NAME.ppo`\n\nHyperparameters of PPO.\n\n| key | default | |\n|---|---|---|\n"
        + "\n".join(rows)
    )


def main() -> None:
    """Write the page, or say that it is stale."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n\n")[0])
    parser.add_argument(
        "--check", action="store_true", help="write nothing; fail where the page is not up to date"
    )
    check = parser.parse_args().check
    old = PAGE.read_text(encoding="utf-8")
    begin, end = (old.index(mark) for mark in MARKS)
    new = f"{old[:begin]}{MARKS[0]}\n\n{reference()}\n\n{old[end:]}"
    if check and new != old:
        sys.exit(f"{PAGE} is not up to date: run python tools/make_reference.py")
    if not check:
        PAGE.write_text(new, encoding="utf-8")


if __name__ == "__main__":
    main()
