"""The knobs that a world names: which numbers its page offers as sliders, and between which ends."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ecs_eco.config.models.viewer import Knob
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.mutable_keys import why_not
from ecs_eco.config.parameters import coded, parameters
from ecs_eco.config.ranges import Key, key_of, name_of, real_key
from ecs_eco.engine.errors import Problem, listed, nearest


def check_knobs(config: WorldConfig, set_: Iterable[Key] = ()) -> list[Problem]:
    """Problems of [viewer]: knobs without a number, a width or an effect; not of values set from outside."""
    if not config.viewer.knobs:
        return []
    data, knobs = config.model_dump(), config.viewer.knobs
    keys = (".".join(map(str, real_key(data, key_of(knob.key))[0])) for knob in knobs)
    rows = {row["key"] for row in parameters(config, keys)}
    outside = {tuple(map(str, key)) for key in set_}
    problems: list[Problem] = []
    seen: set[Key] = set()
    for i, knob in enumerate(config.viewer.knobs):
        key, value, wrong = real_key(data, key_of(knob.key))
        place: Key = ("viewer", "knobs", i)
        if any(
            tuple(map(str, parts[:n])) in outside
            for parts in (key, key_of(knob.key))
            for n in range(1, len(parts) + 1)
        ):
            continue
        if wrong is not None:
            problems.append(wrong.moved(key=(*place, "key"), value=knob.key))
        elif key in seen:
            problems.append(Problem((*place, "key"), "is a knob already", knob.key, "each key once"))
        elif (name := ".".join(map(str, key))) not in rows or isinstance(value, bool):
            problems.append(_not_offered(config, (*place, "key"), knob, name, value))
        else:
            problems += _check_ends(place, knob, value)
        seen.add(key)
    return problems


def _not_offered(config: WorldConfig, place: Key, knob: Knob, name: str, value: Any) -> Problem:
    """The problem of a key whose value is there, but cannot be a knob."""
    known = [row["key"] for row in parameters(config)]
    numbers = "the key of a number that may change in a run"
    if why := why_not(name, type(config)):
        return Problem(place, f"cannot change in a living world: {name}", knob.key, f"{numbers}; or {why}")
    if isinstance(value, bool) or not isinstance(value, int | float):
        fault = f"has no value yet: {name}" if value is None else f"holds no number: {name} = {value!r:.60}"
        return Problem(place, fault, knob.key, numbers, nearest(name, known))
    if gene := coded(config).get(name):
        return Problem(
            place,
            f"the gene {gene} codes for it, so each organism has its own",
            knob.key,
            "values that no gene codes for",
        )
    return Problem(
        place,
        "has no effect in a run that lives",
        knob.key,
        f"a number that has one, as {listed(known[:3])}",
        nearest(name, known),
    )


def _check_ends(place: Key, knob: Knob, value: float) -> list[Problem]:
    if not knob.min < knob.max:
        return [Problem((*place, "max"), "is no range", knob.max, f"more than min, {knob.min:g}")]
    if not knob.min <= value <= knob.max:
        end = "min" if value < knob.min else "max"
        return [
            Problem(
                (*place, end),
                f"does not hold the world's own value, {value:g}",
                getattr(knob, end),
                "a range around it",
            )
        ]
    return []


def offered(config: WorldConfig | None) -> dict[str, Any]:
    """Return what pages may change: "list", all numbers and switches, and "knobs", those a world names."""
    if config is None:
        return {"list": [], "knobs": []}
    rows = parameters(config)
    units = {row["key"]: row["unit"] for row in rows}
    data, knobs = config.model_dump() if config.viewer.knobs else {}, []
    for knob in config.viewer.knobs:
        key = ".".join(map(str, real_key(data, key_of(knob.key))[0]))
        if key in units:
            knobs.append(
                {
                    "key": key,
                    "label": knob.label or name_of(key_of(knob.key)),
                    "low": knob.min,
                    "high": knob.max,
                    "unit": units[key] if knob.unit is None else knob.unit,
                }
            )
    return {"list": rows, "knobs": knobs}
