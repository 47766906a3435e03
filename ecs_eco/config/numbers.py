"""Every number in a section of the world file: its key, range and unit."""

import types
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from ecs_eco.inputs.section import COLUMN, LARGEST, Column, Own, Section

Key = tuple[str, ...]
PLACE = "*"  # in a pattern: a name chosen in the file, or a list index


@dataclass(frozen=True)
class Number:
    """A number in a section's schema; `pattern` is its key with * for names chosen in the file."""

    pattern: Key
    low: float
    high: float
    above: bool  # whether `low` itself is excluded
    whole: bool
    unit: str
    text: str
    own: bool | str | Column | None = None  # whether a gene can code for it (see `Own`)

    @property
    def name(self) -> str:
        """The pattern as a dotted key."""
        return ".".join(self.pattern)

    @property
    def codable(self) -> bool:
        """Whether a gene can code for the number."""
        return self.own in (True, COLUMN) or isinstance(self.own, Column)


@cache
def numbers_of(model: type[Section]) -> dict[Key, Number]:
    """Return every number that a section and its subsections can contain, by pattern."""
    out: dict[Key, Number] = {}
    default = model.marks[1]
    for name, field in model.model_fields.items():
        own = next((mark for mark in field.metadata if isinstance(mark, Own)), default)
        kind = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
        for number in _numbers((name,), kind, field, (-LARGEST, LARGEST, False)):
            if number.own is None and own is not None:
                number = replace(number, own=own.own)
            out.setdefault(number.pattern, number)
    return out


def _numbers(key: Key, kind: Any, field: FieldInfo, span: tuple[float, float, bool]) -> Iterator[Number]:
    """Yield the numbers that a type can contain."""
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Annotated:
        for mark in arguments[1:]:
            for limit in [*mark.metadata] if isinstance(mark, FieldInfo) else [mark]:
                span = narrowed(span, limit)
        yield from _numbers(key, arguments[0], field, span)
    elif origin in (Union, types.UnionType):
        for part in arguments:
            yield from _numbers(key, part, field, span)
    elif origin in (dict, list):
        yield from _numbers((*key, PLACE), arguments[-1], field, span)
    elif isinstance(kind, type) and issubclass(kind, Section):
        for pattern, number in numbers_of(kind).items():
            yield replace(number, pattern=(*key, *pattern))
    elif kind in (int, float):
        yield _number(key, kind is int, field, span)
    elif origin is Literal and all(type(value) is int for value in arguments):
        yield _number(key, True, field, (min(arguments), max(arguments), False))


def _number(key: Key, whole: bool, field: FieldInfo, span: tuple[float, float, bool]) -> Number:
    extra = field.json_schema_extra
    unit = str(extra.get("unit", "1")) if isinstance(extra, dict) else "1"
    text = (field.description or "").removesuffix(f" [{unit}]")
    return Number(key, *span, whole, unit, text)


def narrowed(span: tuple[float, float, bool], limit: object) -> tuple[float, float, bool]:
    """Return a range narrowed by a limit from the annotated_types package."""
    low, high, above = span
    ends = {w: float(x) for w in ("gt", "ge", "le", "lt") if (x := getattr(limit, w, None)) is not None}
    low, high = ends.get("gt", ends.get("ge", low)), ends.get("le", ends.get("lt", high))
    return low, high, above or "gt" in ends


def values_in(section: Section) -> Iterator[tuple[Number, Key, float]]:
    """Yield (number, key, value) for every number in a section, in schema order.

    In the key, a list entry is represented by its name, food or property or, failing these, by its index.
    """
    schema = numbers_of(type(section))
    for field in type(section).model_fields:
        for pattern, key, value, number in _values((field,), (field,), getattr(section, field)):
            known = schema.get(pattern) if number is None else replace(number, pattern=pattern)
            if known is not None:  # the schema does not describe untyped tables
                yield known, key, value


def _values(pattern: Key, key: Key, value: object) -> Iterator[tuple[Key, Key, float, Number | None]]:
    """Yield the numbers in a value; if the number is None, the section's schema describes it."""
    if isinstance(value, Section):
        for number, below, own in values_in(value):
            yield (*pattern, *number.pattern), (*key, *below), own, number
    elif isinstance(value, dict | list):
        entries = value.items() if isinstance(value, dict) else zip(labels(value), value, strict=True)
        for name, entry in entries:
            yield from _values((*pattern, PLACE), (*key, str(name)), entry)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield pattern, key, float(value), None


def labels(entries: list[Any]) -> list[str]:
    """Return labels for list entries: name, food or property, numbered if not unique; otherwise the index."""
    words = ("label", "name", "eats", "property")
    return numbered(
        [str(next(filter(None, (getattr(e, w, None) for w in words)), i)) for i, e in enumerate(entries)]
    )


def numbered(names: list[str]) -> list[str]:
    """Return the same names; those that occur more than once are numbered from 1."""
    shared, seen, out = Counter(names), Counter[str](), []
    for name in names:
        seen[name] += 1
        out.append(f"{name}_{seen[name]}" if shared[name] > 1 else name)
    return out


def with_value(part: Any, key: Key, value: float) -> Any:
    """Return a copy of a section, table or list with a new value at `key`, which is a key from `values_in`."""
    if not key:
        return value
    name, below = key[0], key[1:]
    if isinstance(part, Section):
        return part.model_copy(update={name: with_value(getattr(part, name), below, value)})
    if isinstance(part, dict):
        return part | {name: with_value(part[name], below, value)}
    place = labels(part).index(name)
    return [*part[:place], with_value(part[place], below, value), *part[place + 1 :]]
