"""The keys of a world that name code, derived from the types of its fields so that no new key is missed."""

from collections.abc import Iterator
from functools import cache
from typing import Any

from pydantic import BaseModel

from ecs_eco.config.features.feature import Feature, features_of
from ecs_eco.config.former import is_section, types_in
from ecs_eco.config.rules import Key
from ecs_eco.inputs.code import SHIPPED, public_module
from ecs_eco.inputs.section import NamesCode, Section, Use, function_name


def names_in(section: object, key: Key = ()) -> Iterator[tuple[Key, Any]]:
    """Yield every function or "module:name" in a section and its subsections, by key."""
    for place, value in used_in(section, key):
        yield ((*place, "use"), value.use) if isinstance(value, Use) else (place, value)


def used_in(section: object, key: Key = (), marked: bool = False) -> Iterator[tuple[Key, Any]]:
    """Yield each function, "module:name" or Use, by key; `marked` means that the field can name code."""
    if isinstance(section, BaseModel) and not (marked and isinstance(section, Use)):
        fields = fields_of(type(section))
        for word in _deep_fields_of(type(section)):
            yield from used_in(getattr(section, word), (*key, word), word in fields)
    elif isinstance(section, dict | list):
        for part, value in section.items() if isinstance(section, dict) else enumerate(section):
            yield from used_in(value, (*key, part), marked)
    elif callable(section) or (
        marked and (":" in section if isinstance(section, str) else section is not None)
    ):
        yield key, section


@cache
def fields_of(model: type[BaseModel]) -> frozenset[str]:
    """Return the fields of a model whose values can name code."""
    return frozenset(
        name
        for name, field in model.model_fields.items()
        if any(isinstance(mark, NamesCode) for mark in (*field.metadata, *types_in(field.annotation)))
    )


@cache
def _deep_fields_of(model: type[BaseModel]) -> tuple[str, ...]:
    """Return the fields of a model that can name code, directly or in their contents."""
    return tuple(
        name
        for name, field in model.model_fields.items()
        if name in fields_of(model)
        or any(
            part is Any or (is_section(part) and _deep_fields_of(part)) for part in types_in(field.annotation)
        )
    )


def is_component(thing: object) -> bool:
    """Return whether a value is a class declared with @ecs_eco.component."""
    return isinstance(thing, type) and isinstance(getattr(thing, "fields", None), dict)


def own_features(config: Any) -> list[type[Feature]]:
    """Return the custom features of a world's species."""
    models: list[type[Section]] = list(dict.fromkeys(map(type, config.species.values())))
    found = dict.fromkeys(feature for model in models for feature in features_of(model))
    return [feature for feature in found if not feature.__module__.startswith("ecs_eco.")]


def code_of(config: Any) -> list[str]:
    """Return the entries of `code`, then the modules of functions passed in Python."""
    modules = [
        function_name(value).partition(":")[0]
        for key, value in names_in(config)
        if key[0] != "search" and not isinstance(value, str) and function_name(value) not in SHIPPED
    ]
    modules += [public_module(feature.__module__) for feature in own_features(config)]
    known = [entry.removesuffix(".py") for entry in config.code]
    return [*config.code, *(m for m in dict.fromkeys(modules) if m not in known)]
