"""Find the likely meaning of an unknown key: in its section, in a variant of it, or in a nearby section."""

import typing
from collections.abc import Iterator, Mapping
from dataclasses import fields
from itertools import chain, takewhile
from typing import Any, NamedTuple

from ecs_eco.config.former import is_section, tags_of
from ecs_eco.config.ranges import name_of
from ecs_eco.config.rules import Key
from ecs_eco.engine.errors import CLOSE, nearest
from ecs_eco.inputs.section import Section
from ecs_eco.learning import aliases
from ecs_eco.learning.settings import PPO

NAMED = ("species", "fields", "objects", "substances")  # tables whose keys are chosen in the world file
SYNONYMS = {  # terms of other programs and papers → our terms
    **aliases.ALIASES,
    "timestep": "dt",
    "time_step": "dt",
    "steps": "ticks",
    "duration": "ticks",
    "random_seed": "seed",
    "population": "count",
    "n": "count",
    "reward": "happiness",
    "boundary": "edges",
    "birth_rate": "rate",
    "velocity": "speed",
    "layers": "hidden",
}
ONE_LETTER = 0.9  # similarity of words that differ by one letter; preferred over the same key elsewhere
EVERYWHERE = ("name", "kind", "title", "description")  # words too common to show which section is meant
NEAR = 2  # maximum steps up and down from the section of an unknown key to the section that has it


class Place(NamedTuple):
    """A possible key of a world: the kind of its section, and whether the world has such a section."""

    key: Key
    kind: str
    present: bool


def suggestion(
    key: Key, data: Mapping[str, Any], model: type[Section], places: list[Place], siblings: tuple[str, ...]
) -> str:
    """Return the most likely meaning of an unknown key: a key of its section, a full dotted key, or ""."""
    word = str(key[-1])
    if len(key) == 1 and (table := _table_of(word, data, model)):
        return name_of((table, *key, *_only_parts(data.get(word))))
    return next(filter(None, _guesses(key, word, places, siblings)), "")


def kind_of_key(key: Key, places: list[Place]) -> str:
    """Return the first kind of section, other than its own, that has this unknown key, or ""."""
    return next((place.kind for place in places if place.key == key and place.kind), "")


def _table_of(word: str, data: Mapping[str, Any], model: type[Section]) -> str:
    """Return the table that has an entry with this name, or whose entries have the keys under it."""
    keys = set(_table(data.get(word)))
    for table in (name for name in NAMED if name in model.model_fields):
        entry = typing.get_args(model.model_fields[table].annotation)[-1]
        if word in _table(data.get(table)):
            return table
        if len(keys) > 1 and keys <= set(getattr(entry, "model_fields", ())):
            return table
    return ""


def _guesses(key: Key, word: str, places: list[Place], siblings: tuple[str, ...]) -> Iterator[str]:
    """Yield guesses, most likely first."""
    known = SYNONYMS.get(word, "")
    yield nearest(word, siblings, ONE_LETTER)
    yield _closest(key, word, places)
    yield nearest(word, siblings, CLOSE)
    yield known if known in siblings else ""
    yield _closest(key, known, places)
    yield nearest(word, siblings)
    names = dict.fromkeys(str(place.key[-1]) for place in places)
    yield _closest(key, nearest(word, names, CLOSE), places)


def _closest(key: Key, word: str, places: list[Place]) -> str:
    """Return the key with this name in the sections closest to an unknown key's section, or "" if not unique.

    Sections present in the world come first.
    """
    found: dict[tuple[int, bool], dict[Key, Key]] = {}
    for place in places:
        if (
            place.key[-1] == word
            and word not in EVERYWHERE
            and (steps := _steps(key[:-1], place.key[:-1])) is not None
        ):
            pattern = tuple(part for part in place.key if isinstance(part, str))
            found.setdefault((steps, not place.present), {}).setdefault(pattern, place.key)
    closest = found[min(found)] if found else {}
    return name_of(next(iter(closest.values()))) if len(closest) == 1 else ""


def _steps(here: Key, there: Key) -> int | None:
    """Return the steps up and down from one section to another; None if they have little in common."""
    common = len([*takewhile(lambda pair: pair[0] == pair[1], zip(here, there, strict=False))])
    up, down = len(here) - common, len(there) - common
    if down and up + down > NEAR and common < 2:
        return None
    return up + down


def places_of(model: type[Section], data: object, key: Key = (), kind: str = "") -> Iterator[Place]:
    """Yield all possible keys of a world's sections, for the entries in its data."""
    for name, info in model.model_fields.items():
        yield Place((*key, name), kind, data is not None)
        if name == "ppo":
            yield from (Place((*key, name, f.name), "", True) for f in fields(PPO))
        inner = data.get(name) if isinstance(data, Mapping) else None
        yield from _within(info.annotation, inner, (*key, name))


def _within(annotation: Any, data: object, key: Key) -> Iterator[Place]:
    """Yield the keys of the sections in a type: a section, a union, or a table or list of sections."""
    origin, parts = typing.get_origin(annotation), typing.get_args(annotation)
    if is_section(annotation):
        tags = tags_of(annotation)
        yield from places_of(annotation, data, key, str(tags[0]) if len(tags) == 1 else "")
    elif origin in (dict, list):
        entries = (
            _table(data).items() if origin is dict else enumerate(data) if isinstance(data, list) else ()
        )
        yield from chain.from_iterable(_within(parts[-1], entry, (*key, name)) for name, entry in entries)
    else:
        yield from chain.from_iterable(_within(part, data, key) for part in parts)


def _table(value: object) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}


def _only_parts(value: object) -> Key:
    """Return the path down a table to its first value or branch."""
    if isinstance(value, Mapping) and len(value) == 1:
        ((name, inner),) = value.items()
        return (name, *_only_parts(inner))
    return ()
