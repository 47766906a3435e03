"""Overrides: `--set species.deer.count=50`, or a mapping of dotted keys."""

import copy
import re
from collections.abc import Iterable, Mapping
from typing import Any

from ecs_eco.config.document import Document, Key
from ecs_eco.config.former import both_names, rename
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.ranges import entries_in_words, key_of, names_code, names_of, place_in, real_key
from ecs_eco.config.reading import parse_toml
from ecs_eco.config.suggest import NAMED
from ecs_eco.engine.errors import Problem, listed, nearest, shortened

Overrides = Mapping[str, Any] | Iterable[str] | None
# abbreviations of species keys, only in --set
ALIASES: dict[str, Key] = {"birth_rate": ("reproduction", "rate")}


def apply_overrides(document: Document, overrides: Overrides) -> list[Problem]:
    """Set values in a document; return any problems."""
    problems: list[Problem] = []
    pairs = overrides.items() if isinstance(overrides, Mapping) else [parse(text) for text in overrides or ()]
    for name, value in pairs:
        key = written = key_of(name)
        if len(key) == 3 and key[0] == "species" and key[2] in ALIASES:
            key = (*key[:2], *ALIASES[str(key[2])])
        key, before, kind = both_names(key, document.data, WorldConfig)
        if isinstance(value := copy.deepcopy(value), dict | list):
            document.renamed |= dict(rename(value, kind, key))
        if key[-1:] != written[-1:] and written[-1:] == before[-1:]:
            document.renamed[key] = str(written[-1])
        if isinstance(value, Problem):
            problems.append(value)
        elif re.search(r"(^|\.)(\.|$)", re.sub(r'"[^"]+"', "x", str(name))):  # a part of the key is empty
            allowed = "a key such as species.deer.count"
            problems.append(Problem(("",), "an empty key", str(name), allowed, source=document.set_by))
        elif problem := _put(document, key, written, value):
            problems.append(problem.moved(key=written, value=value, source=document.set_by))
    return problems


def parse(text: str) -> tuple[str, Any]:
    """Return the key and value of "a.b=c"; the value is TOML, and a bare word is a string."""
    name, sign, value = (part.strip() for part in text.partition("="))
    if not sign or not name.strip(". "):
        return name, Problem(
            (), "not of the form key=value", text, "a string such as species.deer.count=50", source="--set"
        )
    try:
        parsed = parse_toml(f"v = {value}")
        if parsed.keys() == {"v"}:
            return name, parsed["v"]
    except ValueError:
        if re.fullmatch(r"[A-Za-z_#][\w-]*", value):
            return name, value
    example = 'a value such as 0.5, true, "text" or [1, 2]'
    return name, Problem((name,), "the value is not TOML", value, example, source="--set")


def _put(document: Document, key: Key, written: Key, value: object) -> Problem | None:
    """Set one value in the data, or return the problem."""
    node: Any = document.data
    real: Key = ()
    for depth, part in enumerate(key):
        if isinstance(node, list):
            if (number := place_in(node, part)) is None:
                fault, near = f"no entry {shortened(str(part))}", nearest(part, names_of(node))
                return Problem(key, fault, allowed=entries_in_words(node), nearest=near)
            part = number
        elif not isinstance(node, dict):
            fault = f"{'.'.join(map(str, real))} has no subkeys"
            return Problem(key, fault, allowed="the key of a table or list")
        elif depth == 1 < len(key) - 1 and key[0] in NAMED and part not in node:
            fault, near = f'no {key[0]} named "{part}"', nearest(part, node)
            return Problem(key, fault, allowed=listed(node), nearest=near)
        real = (*real, part)
        if len(real) == len(key):
            node[part] = value
        elif isinstance(node, dict) and node.get(part) is None:
            node[part] = {}
        elif names_code(node[part]):  # set its first parameter
            node[part] = {"use": node[part]}
        node = node[part]
    document.set[real] = written
    return None


def fix_ranges(document: Document) -> None:
    """Drop the search ranges of values that were set, unless the range was also set."""
    search = document.data.get("search")
    ranges = search.get("ranges") if isinstance(search, dict) else None
    for name in list(ranges) if isinstance(ranges, dict) else ():
        key, _, wrong = real_key(document.data, key_of(name))
        if wrong is None and key in document.set and ("search", "ranges", name) not in document.set:
            del document.data["search"]["ranges"][name]
