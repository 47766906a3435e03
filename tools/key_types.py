"""Types, ranges and defaults of world-file keys, in words. Used by tools/make_reference.py."""

from __future__ import annotations

import math
import types
import typing
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from ecs_eco.config.models.reproduction import Simplified
from ecs_eco.inputs.section import Function, Section

WORDS = {float: "number", int: "integer", bool: "boolean", str: "text"}
OMITTED = (type(None), Simplified)  # a key may be absent; the section has a former kind
LARGEST = 1e6  # larger limits exist only to keep numbers finite or lists within memory
Metadata = tuple[Any, ...]


def models_in(kind: Any, around: str = "") -> Iterator[tuple[type[Section], str]]:
    """Yield the sections that a type contains, each with .NAME if in a table and [] if in a list."""
    if isinstance(kind, type) and issubclass(kind, Section):
        if kind not in OMITTED:
            yield kind, around
        return
    origin = typing.get_origin(kind)
    between = {dict: ".NAME", list: "[]"}.get(origin, "") if isinstance(origin, type) else ""
    for part in typing.get_args(kind):
        yield from models_in(part, around + between)


def type_of(kind: Any, metadata: Metadata, links: Mapping[type[Section], str]) -> str:
    """Return a type in words; `links` contains a link to each section."""
    origin, parts = typing.get_origin(kind), typing.get_args(kind)
    if kind == Function or any(m in Function.__metadata__ for m in metadata):
        return " or ".join(["`module:name`", *(links[model] for model, _ in models_in(kind))])
    if origin is typing.Annotated:
        return type_of(parts[0], parts[1:], links)
    if origin is typing.Literal:
        return WORDS[type(parts[0])]
    if origin in (types.UnionType, typing.Union):
        return _union(parts, metadata, links)
    if origin is list:
        return f"list: {type_of(parts[0], (), links)}"
    if origin is dict:
        return f"table: {type_of(parts[1], (), links)}"
    if isinstance(kind, type) and issubclass(kind, Section):
        return links[kind]
    return WORDS.get(kind, "any")


def _union(parts: tuple[Any, ...], metadata: Metadata, links: Mapping[type[Section], str]) -> str:
    return " or ".join(dict.fromkeys(type_of(p, metadata, links) for p in parts if p not in OMITTED))


def range_of(kind: Any, metadata: Metadata) -> str:
    """Return a type's valid values: choices, limits and list lengths."""
    origin, parts = typing.get_origin(kind), typing.get_args(kind)
    if origin is typing.Annotated:
        return range_of(parts[0], parts[1:])
    if origin is typing.Literal:
        return ", ".join(f"`{written(p)}`" for p in parts)
    if origin in (types.UnionType, typing.Union):
        return " or ".join(dict.fromkeys(r for p in parts if (r := range_of(p, metadata))))
    if origin is list:
        inner, length = range_of(parts[0], ()), _length(metadata)
        return (
            f"{length}, each {inner}".replace("each 2 e", "each of 2 e")
            if inner and length
            else inner or length
        )
    if origin is dict:
        return range_of(parts[1], ())
    return "" if kind not in (int, float) else _limits(metadata)


def _limits(metadata: Metadata) -> str:
    low, above, high, below = (_limit(metadata, name) for name in ("ge", "gt", "le", "lt"))
    if low is not None and high is not None:
        return f"{written(low)} to {written(high)}"
    signs = ((">", above), ("≥", low), ("<", below), ("≤", high))
    return ", ".join(f"{sign} {written(limit)}" for sign, limit in signs if limit is not None)


def _limit(metadata: Metadata, name: str) -> Any:
    found = (getattr(m, name, None) for m in _flat(metadata))
    return next((limit for limit in found if limit is not None and abs(limit) < LARGEST), None)


def _length(metadata: Metadata) -> str:
    low, high = (_limit(metadata, name) for name in ("min_length", "max_length"))
    if low is None:
        return ""
    size = f"{low}" if low == high else f"{low} or more" if high is None else f"{low} to {high}"
    return f"{size} {'entry' if size == '1' else 'entries'}"


def _flat(metadata: Metadata) -> list[Any]:
    """Return a type's limits, including limits wrapped by pydantic."""
    return [inner for m in metadata for inner in getattr(m, "metadata", (m,))]


def default_of(info: FieldInfo) -> str:
    """Return a key's default as TOML, "required" or "absent"."""
    if info.is_required():
        return "required"
    value = info.default_factory() if info.default_factory else info.default  # type: ignore[call-arg]
    if value is None or value is PydanticUndefined:
        return "absent"
    return "" if isinstance(value, Section) else f"`{written(value)}`"


def written(value: Any) -> str:
    """Return a value as TOML; multiples of π are shortened."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        known = {math.pi: "π", -math.pi: "-π", 2 * math.pi: "2π", math.pi / 2: "π/2"}
        return known.get(value, f"{value:g}")
    if isinstance(value, list):
        return "[" + ", ".join(map(written, value)) + "]"
    return "{ }" if value == {} else f'"{value}"' if isinstance(value, str) else str(value)
