"""Numbers written as `{ value = 0.014, search = [0.004, 0.02] }`: their ranges are moved to [search.ranges]."""

import re
from collections.abc import Iterator, Mapping
from typing import Any

from ecs_eco.config.former import both_names
from ecs_eco.config.models.search import OBJECTIVES, Range
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.rules import Key, no_such
from ecs_eco.engine.errors import Problem, listed, nearest
from ecs_eco.inputs.section import LARGEST, NAMED, Use, function_name

PARTS = ("value", "search", "scale")


def key_of(name: str) -> Key:
    """Return the key of a dotted name; parts that contain a dot are quoted."""
    return tuple([part.strip('"') for part in re.findall(r'"[^"]*"|[^.]+', name)])


def name_of(key: Key) -> str:
    """Return the dotted name of a key."""
    return Problem(key, "").path


def take_ranges(data: dict[str, Any]) -> tuple[dict[str, Key], list[Problem]]:
    """Replace numbers that have a range with their values; return the ranges' keys and any problems."""
    ranges: dict[str, Key] = {}
    problems: list[Problem] = []
    for holder, key in list(_tables(data, ())):
        part: Any = holder[key[-1]]
        if "value" not in part:
            problems.append(Problem((*key, "value"), "is missing next to the range", allowed="a number"))
        problems += [
            Problem((*key, k), "unknown key", part[k], listed(PARTS), nearest(k, PARTS))
            for k in part
            if k not in PARTS
        ]
        holder[key[-1]] = part.get("value", 1)
        search = data.setdefault("search", {})
        if isinstance(search, dict) and isinstance(search.setdefault("ranges", {}), dict):
            if name_of(key) in search["ranges"]:
                problems.append(
                    Problem(key, "has a range here and in [search.ranges]", part["search"], "one range")
                )
            ranges[name_of(key)] = key
            search["ranges"][name_of(key)] = {k: v for k, v in part.items() if k in ("search", "scale")}
    return ranges, problems


def _tables(node: object, key: Key) -> Iterator[tuple[Any, Key]]:
    """Yield the tables that contain a number with a range, with their keys."""
    entries = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for name, part in entries:
        if not key and name == "search":
            continue
        if isinstance(part, dict) and "search" in part and not isinstance(part["search"], dict):
            yield node, (*key, name)
        elif isinstance(part, dict | list):
            yield from _tables(part, (*key, name))


def check_search(
    config: WorldConfig, inline: Mapping[str, Key], set_: Mapping[Key, Any]
) -> Iterator[Problem]:
    """Yield problems with the objective and ranges in [search]."""
    yield from _check_objective(config)
    data = config.model_dump() if config.search.ranges else {}
    for name, span in config.search.ranges.items():
        place = (*inline[name], "search") if name in inline else ("search", "ranges", name)
        key, value, wrong = real_key(data, key_of(name))
        if wrong is not None:
            yield wrong.moved(key=place, value=name)
        elif not key or key[0] == "search":
            allowed = "a dotted key, such as species.deer.count"
            yield Problem(place, "not a number of the world", name, allowed)
        else:
            yield from _check_range(name, span, place, value, key in set_)


def _check_range(name: str, span: Range, place: Key, value: object, set_: bool) -> Iterator[Problem]:
    """Yield problems with the range of a value; the value may be outside it if it was set (`set_`)."""
    low, high = given = span.search
    if isinstance(value, bool) or not isinstance(value, int | float):
        fault = "has no value yet" if value is None else "is a range, but its key is not a number"
        shown = "absent" if value is None else repr(value)
        yield Problem(place, f"{fault}: {name} = {shown}", given, "the key of a number")
    elif not -LARGEST <= low < high <= LARGEST:
        yield Problem(place, "not a range", given, "[low, high] with low < high")
    elif span.scale == "log" and low <= 0:
        yield Problem(place, "not possible on a log scale", given, "low > 0")
    elif not low <= value <= high and not set_:
        fault = f"does not contain the world's value, {value:g}"
        yield Problem(place, fault, given, "a range that contains this value")


def real_key(data: Any, key: Key) -> tuple[Key, Any, Problem | None]:
    """Return the key with integer list indices, and its value or the problem with the key."""
    real: list[str | int] = []
    key = both_names(key, data, WorldConfig)[0]
    for part in key:
        if isinstance(data, list) and (number := place_in(data, part)) is not None:
            part = number
        known = (
            [*map(str, range(len(data))), *names_of(data)]
            if isinstance(data, list)
            else list(data)
            if isinstance(data, dict)
            else []
        )
        if str(part) not in known:
            where = name_of(tuple(real)) or "the world"
            fault = f"no {part!r} in {where}" if known else f"{where} has no subkeys"
            return tuple(real), None, Problem(key, fault, allowed=listed(known), nearest=nearest(part, known))
        real.append(int(part) if isinstance(data, list) else part)
        data = data[real[-1]]
    return tuple(real), data, None


def _check_objective(config: WorldConfig) -> Iterator[Problem]:
    search, own, of_all = config.search, [*config.species], [*config.species, *config.reporters]
    known = (*OBJECTIVES, *config.reporters)
    for i, (of, _) in enumerate(search.goals):
        if isinstance(of, str) and of not in known and ":" not in of:
            entry = ("objective", i, "of") if isinstance(search.objective, list) else ("objective",)
            allowed = f"{listed(known, 20)}, or module:function"
            yield Problem(("search", *entry), "no such objective", of, allowed, nearest(of, known))
    for name in (name for name in search.wanted if name not in of_all):
        kind = "species or reporter" if config.reporters else "species"
        yield no_such(("search", "wanted", name), kind, name, of_all)
    for i, name in enumerate(search.persist):
        if name not in own:
            yield no_such(("search", "persist", i), "species", name, own)
    goals = {of for of, _ in search.goals if isinstance(of, str)}
    if "data" in goals and config.data is None:
        fault, allowed = (
            "is missing: the objective of [search] is data",
            'such as [data] file = "pelts.csv"',
        )
        yield Problem(("data",), fault, allowed=allowed)
    if "population" in goals and not {*search.wanted} & {*own}:
        fault, allowed = "is missing: the objective is population", "such as { deer = 500 }"
        yield Problem(("search", "wanted"), fault, allowed=allowed)


def place_in(entries: list[Any], part: str | int) -> int | None:
    """Return the list index to which part of a key refers: a number, or the unique name of an entry."""
    if str(part).isdecimal() and len(str(part)) < 10:
        return int(part) if int(part) < len(entries) else None
    found = [i for i, entry in enumerate(entries) if name_of_entry(entry) == part]
    return found[0] if len(found) == 1 else None


def names_of(entries: list[Any]) -> list[str]:
    """Return the names that exactly one entry has."""
    named = [name_of_entry(entry) for entry in entries]
    return [name for name in named if name and named.count(name) == 1]


def entries_in_words(entries: list[Any]) -> str:
    """Return the numbers and names of a list's entries, as text."""
    if not entries:
        return "none, the list is empty"
    names, last = names_of(entries), len(entries) - 1
    return (f"0 to {last}" if last else "0") + (f", or {listed(names)}" if names else "")


def name_of_entry(entry: object) -> str:
    """Return the name of an entry, or else of the class or function that it uses; "" if unnamed."""
    if isinstance(entry, dict):
        own = entry.get("name")
        return own if isinstance(own, str) else name_of_entry(entry.get("use", entry.get("function")))
    if names_code(entry) or isinstance(entry, Use) or callable(getattr(entry, "process", None)):
        return function_name(entry).partition(":")[2].rpartition(".")[2]
    return ""


def names_code(entry: object) -> bool:
    """Return whether a value is a function or "module:name", without parameters."""
    return callable(entry) or (isinstance(entry, str) and re.fullmatch(NAMED, entry) is not None)
