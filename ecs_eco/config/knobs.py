"""The values that users can change on pages during a run: numbers, switches, and a world's knobs."""

from collections.abc import Container, Iterable, Iterator
from functools import reduce
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from ecs_eco.config.derived import all_genes
from ecs_eco.config.models.search import Knob
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.mutable_keys import why_not
from ecs_eco.config.numbers import labels, narrowed
from ecs_eco.config.ranges import Key, key_of, name_of, real_key
from ecs_eco.config.traits import label_of
from ecs_eco.engine.errors import Problem, listed, nearest
from ecs_eco.inputs.section import LARGEST, Use, function_name

NOT_NOW = frozenset({"ticks", "seed", "training", "interventions"})
Way = tuple[str, ...]


def check_knobs(config: WorldConfig, set_: Iterable[Key] = ()) -> Iterator[Problem]:
    """Yield problems with [viewer]: knobs without a number, a range or an effect."""
    data = config.model_dump() if config.viewer.knobs else {}
    real = [real_key(data, key_of(knob.key)) for knob in config.viewer.knobs]
    names = [".".join(map(str, key)) for key, _, _ in real]
    rows = {row["key"] for row in parameters(config, names)} if names else set()
    outside = {tuple(map(str, key)) for key in set_}
    for i, (knob, (key, value, wrong), name) in enumerate(zip(config.viewer.knobs, real, names, strict=True)):
        place: Key = ("viewer", "knobs", i)
        given = [tuple(map(str, parts)) for parts in (key, key_of(knob.key))]
        if outside & {parts[: n + 1] for parts in given for n in range(len(parts))}:
            continue
        if wrong is not None:
            yield wrong.moved(key=(*place, "key"), value=knob.key)
        elif name in names[:i]:
            yield Problem((*place, "key"), "is already a knob", knob.key, "each key once")
        elif name not in rows or isinstance(value, bool):
            yield _not_offered(config, (*place, "key"), knob, name, value)
        elif not knob.min < knob.max:
            yield Problem((*place, "max"), "is not above min", knob.max, f"more than min, {knob.min:g}")
        elif not knob.min <= value <= knob.max:
            end = "min" if value < knob.min else "max"
            fault = f"the range does not contain the world's value, {value:g}"
            yield Problem((*place, end), fault, getattr(knob, end), "a range that contains it")


def _not_offered(config: WorldConfig, place: Key, knob: Knob, name: str, value: object) -> Problem:
    """Return the problem with a key whose value exists but cannot be a knob."""
    known = [row["key"] for row in parameters(config)]
    numbers = "the key of a number that can change during a run"
    if why := why_not(name, type(config)):
        return Problem(place, f"cannot change during a run: {name}", knob.key, f"{numbers}; or {why}")
    if isinstance(value, bool) or not isinstance(value, int | float):
        fault = f"has no value: {name}" if value is None else f"is not a number: {name} = {value!r:.60}"
        return Problem(place, fault, knob.key, numbers, nearest(name, known))
    if gene := coded(config).get(name):
        fault = f"the gene {gene} codes for it, so it differs between organisms"
        return Problem(place, fault, knob.key, "a value that no gene codes for")
    allowed = f"a number that has an effect, such as {listed(known[:3])}"
    return Problem(place, "has no effect during a run", knob.key, allowed, nearest(name, known))


def offered(config: WorldConfig | None) -> dict[str, Any]:
    """Return the values that pages can change. "list" contains every number and switch; "knobs" contains the
    world's knobs (key, label, unit, low, high), except those without a number in a treatment or on an island."""
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


def parameters(config: WorldConfig, keys: Iterable[str] | None = None) -> list[dict[str, Any]]:
    """Return all numbers and switches that a "set" intervention can change: key, value, whether it is an
    integer, unit, low, high (null: no bound), about. Values that genes code for are left out; dotted `keys`
    limit the selection."""
    parts = [tuple(key.split(".")) for key in keys or ()]
    wanted = None if keys is None else {part[:n] for part in parts for n in range(len(part) + 1)}
    genes = coded(config)
    rows = _walk(config, (), {}, wanted)
    return [
        row
        for row in rows
        if row["key"] not in genes
        and row["key"].split(".")[0] not in NOT_NOW
        and not why_not(row["key"], type(config))
    ]


def coded(config: WorldConfig) -> dict[str, str]:
    """Return the names of genes by the dotted key of the value that they code for."""
    return {
        ".".join(map(str, ("species", name, *key))): gene.name
        for name, species in config.species.items()
        for gene in all_genes(species)
        if gene.trait and (key := _key_of(species, gene.trait))
    }


def _key_of(species: Species, trait: str) -> Key | None:
    """Return the key of a trait's value in a species' section; None if the trait has no such key."""
    kind, _, rest = trait.partition(".")
    name, _, field = rest.rpartition(".")
    if kind == "reflex" and species.reflex is not None:
        for i, connection in enumerate(species.reflex.connections):
            if label_of(connection) == name:
                threshold = "above" if connection.above is not None else "below"
                return ("reflex", "connections", i, threshold if field == "threshold" else field)
    if kind == "happiness" and species.happiness is not None and rest in species.happiness.weights:
        return ("happiness", "weights", rest)
    if trait == "life.age_max":
        return next(
            (
                ("lethal", i, "max")
                for i, limit in enumerate(species.lethal)
                if limit.property == "age" and limit.max is not None
            ),
            None,
        )
    key: list[str | int] = []
    value: Any = species
    for part in trait.split("."):
        if isinstance(value, list):
            entries = {label: str(i) for i, label in enumerate(labels(value))}
            part = entries.get(part, part)
            value = value[int(part)] if part in entries.values() else None
        else:
            value = value.get(part) if isinstance(value, dict) else getattr(value, part, None)
        key.append(part)
    return None if value is None else tuple(key)


def _walk(
    value: object, key: Way, field: dict[str, Any], wanted: Container[Way] | None
) -> Iterator[dict[str, Any]]:
    if wanted is not None and key not in wanted:
        return
    if isinstance(value, Use):
        for name, inner in value.parameters.items():
            about = f"parameter of {function_name(value)}"
            yield from _walk(
                inner, (*key, name), {"unit": "", "low": None, "high": None, "about": about}, wanted
            )
    elif isinstance(value, BaseModel):
        for name, info in type(value).model_fields.items():
            if wanted is not None and (*key, name) not in wanted:
                continue
            yield from _walk(getattr(value, name), (*key, name), _field(info), wanted)
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield from _walk(inner, (*key, str(name)), field, wanted)
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            if isinstance(inner, BaseModel):
                yield from _walk(inner, (*key, str(i)), field, wanted)
    elif isinstance(value, bool | int | float) and key:
        yield {"key": ".".join(key), "value": value, "whole": isinstance(value, int), **field}


def _field(info: FieldInfo) -> dict[str, Any]:
    """Return the unit, bounds and description of a field."""
    extra = info.json_schema_extra if isinstance(info.json_schema_extra, dict) else {}
    low, high, _ = reduce(narrowed, info.metadata, (-LARGEST, LARGEST, False))
    return {
        "unit": str(extra.get("unit", "")),
        "low": low if low > -LARGEST else None,
        "high": high if high < LARGEST else None,
        "about": (info.description or "").rpartition(" [")[0] or info.description or "",
    }
