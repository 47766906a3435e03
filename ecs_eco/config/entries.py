"""Entries of lists by name: `systems.Disease.beta` is the beta of the system Disease, wherever it stands."""

from __future__ import annotations

import re
from typing import Any

from ecs_eco.engine.errors import listed
from ecs_eco.engine.section import NAMED, Use, function_name


def is_index(part: str) -> bool:
    """Whether a part of a key is a list index: a number of few digits."""
    return part.isdecimal() and len(part) < 10


def place_in(entries: list[Any], part: str | int) -> int | None:
    """The index that a part of a key says, by number or by a name that one entry has; None for none."""
    if is_index(str(part)):
        return int(part) if int(part) < len(entries) else None
    named = [i for i, entry in enumerate(entries) if name_of_entry(entry) == part]
    return named[0] if len(named) == 1 else None


def names_of(entries: list[Any]) -> list[str]:
    """The names that one entry each has."""
    named = [name_of_entry(entry) for entry in entries]
    return [name for name in named if name and named.count(name) == 1]


def entries_in_words(entries: list[Any]) -> str:
    """The numbers and names of the entries of a list."""
    if not entries:
        return "none, the list is empty"
    names, last = names_of(entries), len(entries) - 1
    return (f"0 to {last}" if last else "0") + (f", or {listed(names)}" if names else "")


def name_of_entry(entry: Any) -> str:
    """The name of an entry: its own, or that of the class or function that it uses; "" for none."""
    if isinstance(entry, dict):
        own = entry.get("name")
        return own if isinstance(own, str) else name_of_entry(entry.get("use", entry.get("function")))
    if names_code(entry) or isinstance(entry, Use) or callable(getattr(entry, "process", None)):
        return function_name(entry).partition(":")[2].rpartition(".")[2]
    return ""


def names_code(entry: Any) -> bool:
    """Whether something is a function or "module:name", without parameters."""
    return callable(entry) or (isinstance(entry, str) and re.fullmatch(NAMED, entry) is not None)
