"""Former names of keys, declared by fields with `former`. They are still accepted, and hashes use them."""

import types
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Annotated, Any, Union, get_args, get_origin

from ecs_eco.config.numbers import labels
from ecs_eco.config.rules import Key
from ecs_eco.engine.errors import Problem
from ecs_eco.inputs.section import Section
from ecs_eco.learning.aliases import FORMER

KINDS = {"simplified": "asexual"}  # former kinds of a section → the kinds that replace them


@cache
def present_names(model: type[Section]) -> dict[str, str]:
    """Return the current name of each renamed key of a section, by its former name."""
    fields = model.model_fields.items()
    return {field.alias: name for name, field in fields if field.alias}


def rename(data: Any, kind: Any, key: Key = ()) -> Iterator[tuple[Key, str]]:
    """Rename keys in a section's data to their current names; yield each key and its former name."""
    if not has_former(kind):
        return
    kind = type_of(kind, data)
    if isinstance(data, dict) and is_section(kind) and (names := present_names(kind)).keys() & data.keys():
        now = {names.get(name, name): value for name, value in data.items()}
        if len(now) == len(data):  # otherwise both names of a key are given, and the former one is rejected
            yield from [((*key, names[name]), name) for name in data if name in names]
            data.clear()
            data.update(now)
    for part, value in data.items() if isinstance(data, dict) else enumerate(data):
        if isinstance(value, dict | list):
            yield from rename(value, below(kind, data, part)[0], (*key, part))


def both_names(key: Key, data: Any, kind: Any) -> tuple[Key, Key, Any]:
    """Return a key with its current names and with its former names, and its type; `kind` is that of `data`."""
    now, before = list(key), list(key)
    for i, part in enumerate(key):
        kind = type_of(kind, data)
        if is_section(kind):
            now[i] = part = present_names(kind).get(str(part), part)
            field = kind.model_fields.get(str(part))
            before[i] = (field and field.alias) or part
        elif now[max(i - 1, 0)] == "ppo":
            now[i] = FORMER.get(str(part), part)
            before[i] = next((old for old, name in FORMER.items() if name == now[i]), part)
        kind, data = below(kind, data, part)
    return tuple(now), tuple(before), kind


def by_former_names(config: Any) -> dict[str, Any]:
    """Return a world's configuration with JSON types and the former names of its keys."""
    data: dict[str, Any] = config.model_dump(mode="json", by_alias=True)

    def before(name: str, section: Section) -> str:
        return ".".join(map(str, both_names(tuple(name.split(".")), section, None)[1]))

    for species, own in zip(config.species.values(), data["species"].values(), strict=True):
        way = own["reproduction"] or {}
        if (way.get("kind"), way.get("place")) == ("asexual", "anywhere"):
            way |= {"kind": "simplified", "dispersal": None}
        own["ppo"] = {before(f"ppo.{name}", species)[4:]: value for name, value in own["ppo"].items()}
        genome = own["genome"] or {"genes": []}
        for coded in (*genome["genes"], *genome.get("derived", {}).values()):
            coded["trait"] = coded["trait"] and before(coded["trait"], species)
    for values in (
        data["training"]["set"],
        *(data.get("archipelago") or {}).get("islands", {}).values(),
        *(planned["set"] for planned in data["interventions"] if planned["kind"] == "set"),
    ):
        renamed = {before(name, config): value for name, value in values.items()}
        values.clear()
        values.update(renamed)
    return data


def notes_on(renamed: Mapping[Key, str], config: Any) -> Iterator[str]:
    """Yield the current name of each key that was given under a former name, at its first occurrence."""
    first = {(former, key[-1]): key for key, former in reversed([*renamed.items()])}
    yield from (
        f"{Problem(key, '').path} is the present name of {former}"
        for (former, _), key in reversed(first.items())
    )
    for name, species in config.species.items():
        if (way := species.reproduction) is not None and way.kind == "simplified":
            yield f'species.{name}.reproduction: write kind = "asexual", place = "{way.place}" for simplified'


@cache
def is_section(kind: object) -> bool:
    """Return whether a type is a section."""
    return isinstance(kind, type) and issubclass(kind, Section)


def types_in(kind: object) -> Iterator[Any]:
    """Yield a type, and the types and annotations that make it up."""
    yield kind
    for part in get_args(kind):
        yield from types_in(part)


@cache
def has_former(kind: Any) -> bool:
    """Return whether values of a type can contain a key that has a former name."""
    sections = filter(is_section, types_in(kind))
    return any(
        present_names(s) or any(has_former(f.annotation) for f in s.model_fields.values()) for s in sections
    )


def below(kind: Any, data: Any, part: str | int) -> tuple[Any, Any]:
    """Return the type and value of one part of a section, table or list; None for what is unknown."""
    if is_section(kind):
        field = kind.model_fields.get(str(part))
        own = data.get(part) if isinstance(data, dict) else getattr(data, str(part), None)
        return field and field.annotation, own
    inner = (get_args(kind) or (None,))[-1]
    if isinstance(data, list):
        if str(part).isdecimal() and len(str(part)) < 10:  # int() rejects thousands of digits
            return inner, data[int(part)] if int(part) < len(data) else None
        names = (
            e.get("name") if isinstance(e, dict) else label
            for e, label in zip(data, labels(data), strict=True)
        )
        return inner, next((e for e, name in zip(data, names, strict=True) if name == part), None)
    return inner, data.get(part) if isinstance(data, dict) else None


def type_of(kind: Any, data: object) -> Any:
    """Return a type without Annotated and None; for a union of sections, the one with the data's `kind`."""
    if isinstance(data, Section):
        return type(data)
    members = members_of(kind)
    if len(members) > 1 and isinstance(data, dict):
        tag = data.get("kind")
        for member in members:  # a union can contain sections along with lists or words
            if tag in tags_of(member) if tag is not None else is_section(member):
                return member
    return members[0]


@cache
def members_of(kind: object) -> tuple[Any, ...]:
    """Return the members of a union type, without Annotated and None."""
    if get_origin(kind) is Annotated:
        return members_of(get_args(kind)[0])
    if get_origin(kind) in (types.UnionType, Union):
        return tuple(own for part in get_args(kind) if part is not type(None) for own in members_of(part))
    return (kind,)


@cache
def tags_of(section: object) -> tuple[Any, ...]:
    """Return the possible kinds of a section."""
    info = getattr(section, "model_fields", {}).get("kind")
    return get_args(info.annotation) if info else ()
