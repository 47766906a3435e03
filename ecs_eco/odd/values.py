"""The values in a world file and the fields of components, with meanings and units from their declarations."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from pydantic.fields import FieldInfo

from ecs_eco.config.numbers import labels
from ecs_eco.engine.table import Table
from ecs_eco.inputs.section import Section, Use, function_name
from ecs_eco.learning.settings import PPO

_UNIT_AT_END = re.compile(r" \[([^]]*)\]$")
TECHNICAL = ("device",)  # keys that never change results
PPO_TEXTS = {field.name: str(field.metadata["doc"]) for field in dataclasses.fields(PPO)}


class Value(NamedTuple):
    """A value of a section."""

    key: str
    value: Any
    unit: str = ""
    text: str = ""


def values_of(section: Section, prefix: str = "") -> Iterator[Value]:
    """Yield the values of a section and its subsections: all given values, and defaults that have an effect.
    `lists_of` yields lists of sections."""
    for name, info, value in _fields(section):
        key, unit, text = f"{prefix}{name}", unit_of(info), text_of(info)
        if isinstance(value, Section) and not isinstance(value, Use):
            yield from values_of(value, f"{key}.")
        elif isinstance(value, dict):
            texts = PPO_TEXTS if name == "ppo" else {}
            for entry, one in value.items():
                if not isinstance(one, Section) and not (name == "ppo" and _is_unused(section, entry, one)):
                    yield Value(f"{key}.{entry}", one, unit, texts.get(entry, text))
        elif not _sections(value) and name != "kind":
            yield Value(key, value, unit, text)


def _is_unused(section: Section, setting: str, value: object) -> bool:
    """Return whether a PPO hyperparameter has no effect: it is 0, or applies only to recurrent networks."""
    return not value or (setting == "unroll" and next(found_at(section, ["policy", "network"]), None) is None)


def keys_given(section: Section) -> set[str]:
    """Return the keys of the values that a file sets within a section."""
    keys = {value.key for value in values_of(section)}
    return {key for key in keys if key.partition(".")[0] in section.model_fields_set}


def lists_of(section: Section, prefix: str = "") -> Iterator[tuple[str, list[tuple[str, Section]]]]:
    """Yield each list or table of sections within a section: its key and its named entries."""
    for name, _, value in _fields(section):
        if isinstance(value, Section):
            yield from lists_of(value, f"{prefix}{name}.")
        elif isinstance(value, list) and _sections(value):
            yield f"{prefix}{name}", list(zip(labels(value), value, strict=True))
        elif isinstance(value, dict) and (held := [i for i in value.items() if isinstance(i[1], Section)]):
            yield f"{prefix}{name}", held


def _fields(section: Section) -> Iterator[tuple[str, FieldInfo, Any]]:
    """Yield the effective values of a section's own fields and of its functions' parameters."""
    for name, info in type(section).model_fields.items():
        value = getattr(section, name)
        given = name in section.model_fields_set
        idle = name in TECHNICAL or (_is_idle(info, value) and not given)
        if value is not None and value not in ("", {}) and not idle:
            yield name, info, value
    for name, value in (section.__pydantic_extra__ or {}).items():
        yield name, FieldInfo(), value


def _is_idle(info: FieldInfo, value: object) -> bool:
    """Return whether a default has no effect: 0, false, "none", or a value that files omit."""
    return not value or value == "none" or (info.exclude_if is not None and info.exclude_if(value))


def _sections(value: object) -> bool:
    return isinstance(value, list) and any(isinstance(entry, Section) for entry in value)


def unit_of(info: FieldInfo) -> str:
    """Return the unit of a field, or "" for a pure number."""
    extra = info.json_schema_extra
    written = _UNIT_AT_END.search(info.description or "")
    unit = written[1] if written else ""
    unit = str(extra["unit"]) if isinstance(extra, dict) and "unit" in extra else unit
    return "" if unit == "1" else unit


def text_of(info: FieldInfo) -> str:
    """Return the description of a field, without its unit or the effect of its absence."""
    text = _UNIT_AT_END.sub("", info.description or "")
    return re.sub(r"[;,:]? (?:absent|default): [^;]*", "", text)


def shown(value: object) -> str:
    """Return a value as text; numbers are as short as their precision allows."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}"
    if isinstance(value, float):
        short = f"{value:,g}"
        exact = abs(float(short.replace(",", "")) - value) <= 1e-6 * abs(value)
        return (short if exact else repr(value)).replace("e-0", "e-").replace("e+0", "e")
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(shown, value))}]"
    if isinstance(value, dict):
        return ", ".join(f"{key} = {shown(one)}" for key, one in value.items())
    if isinstance(value, Use):
        return f"{value.use} ({shown(value.parameters)})"
    return value if isinstance(value, str) else function_name(value)


def applies(condition: str, places: Iterable[Section], table: Table | None = None) -> bool:
    """Return whether a condition of `Submodel` is true for any of several sections, or for a table."""
    held = list(places)
    return all(_one_applies(key.strip(), held, table) for key in condition.split("&"))


def _one_applies(key: str, places: list[Section], table: Table | None) -> bool:
    if key[:1].isupper():
        return table is not None and any(component.__name__ == key for component in table)
    path, _, wanted = key.partition("=")
    found = [value for place in places for value in found_at(place, path.split("."))]
    return any(str(value) == wanted if wanted else _is_set(value) for value in found) if key else True


def found_at(value: Any, path: list[str]) -> Iterator[Any]:
    """Yield all values at a dotted key, including those in entries of lists and tables of sections."""
    if not path:
        yield value
    elif isinstance(value, Section):
        if path[0] in type(value).model_fields or path[0] in (value.__pydantic_extra__ or {}):
            yield from found_at(getattr(value, path[0]), path[1:])
    elif isinstance(value, list | dict):
        for entry in value.values() if isinstance(value, dict) else value:
            yield from found_at(entry, path)


def _is_set(value: object) -> bool:
    return any(value.values()) if isinstance(value, dict) else bool(value)


def sentences(thing: Any, whole: bool = True) -> str:
    """Return the docstring of a class or function, or its first paragraph, as one line; "" if it has none."""
    own = vars(thing).get("__doc__") if isinstance(thing, type) else getattr(thing, "__doc__", "")
    text = inspect.cleandoc(own or "")
    return " ".join((text if whole else text.partition("\n\n")[0]).split())


def first_sentence(thing: Any) -> str:
    """Return the first sentence of a class's or function's docstring."""
    return re.split(r"(?<=[.!?])\s+(?=[A-Z`])", sentences(thing), maxsplit=1)[0]
