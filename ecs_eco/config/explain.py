"""Describe pydantic's errors: the key, the value, the expected value, and the nearest valid name."""

import typing
from typing import Any

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from ecs_eco.config.former import KINDS, below, is_section, tags_of, type_of, types_in
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.rules import Key
from ecs_eco.config.suggest import Place, kind_of_key, places_of, suggestion
from ecs_eco.engine.errors import MISSING, MOST, Problem, listed, nearest
from ecs_eco.inputs.section import Section

FORMS = ("names", "range", "word", "number", "with")  # tags of unions whose members have no `kind`
WORDS: dict[Any, str] = {
    float: "a finite number",
    int: "a whole number",
    bool: "true or false",
    str: "text",
    list: "a list",
    dict: "a table",
}
LIMITS = {
    "greater_than": "more than {gt:g}",
    "greater_than_equal": "at least {ge:g}",
    "less_than": "less than {lt:g}",
    "less_than_equal": "at most {le:g}",
    "too_short": "at least {min_length} entries",
    "too_long": "at most {max_length} entries",
    "string_too_long": "at most {max_length} characters",
    "string_pattern_mismatch": "text that matches {pattern}",
}


def problems_of(
    error: ValidationError, data: dict[str, Any], model: type[Section] = WorldConfig
) -> list[Problem]:
    """Return one problem for each of pydantic's errors in data for a model, at most MOST + 1."""
    errors = error.errors(include_url=False, include_input=False)[: MOST + 1]
    unknown = any(e["type"] == "extra_forbidden" for e in errors)
    places = list(places_of(model, data)) if unknown else []
    return [_problem(e, data, model, places) for e in errors]


def value_at(data: Any, key: Key) -> Any:
    """Return the value at a key, or MISSING."""
    for part in key:
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            return MISSING
    return data


def _problem(error: Any, data: dict[str, Any], model: type[Section], places: list[Place]) -> Problem:
    key, kind, context = _key(error["loc"], data), error["type"], error.get("ctx", {})
    value = value_at(data, key)
    info, parent = field_at(key, data, model)
    about = f" ({info.description})" if info is not None and info.description else ""
    if kind == "missing":
        return Problem(key, "is missing", allowed=_words(info) + about)
    if kind == "extra_forbidden" and info is not None:
        return Problem(key, f"is given twice: also by its former name {info.alias}", value, "one name")
    if kind == "extra_forbidden":
        known = tuple(parent.model_fields) if parent else ()
        near = suggestion(key, data, model, places, known)
        tag = "" if near in known else kind_of_key(key, places)
        fault = f'unknown key here; it exists for kind = "{tag}"' if tag else "unknown key"
        return Problem(key, fault, value, listed(known, 40), "" if tag else near)
    if kind.startswith("union_tag"):
        tags = [tag for part in types_in(info.annotation if info else None) for tag in tags_of(part)]
        tag = value.get("kind", MISSING) if isinstance(value, dict) else MISSING
        fault = "is missing" if tag is MISSING else "unknown kind"
        near, present = nearest(tag, tags), (of for of in tags if of not in KINDS)
        return Problem((*key, "kind"), fault, tag, listed(present), KINDS.get(near, near))
    if kind in ("literal_error", "enum"):
        choices = [str(c) for c in typing.get_args(type_of(info.annotation, None))] if info else []
        return Problem(key, "no such choice", value, listed(choices) + about, nearest(value, choices))
    if error["loc"] and error["loc"][-1] == "[key]":
        return Problem(key, "not a name", allowed="a letter, then letters, digits or _ (at most 40)")
    if kind in LIMITS:
        fault = {"string_pattern_mismatch": "not of this form"}.get(kind, "out of range")
        return Problem(key, fault, value, LIMITS[kind].format(**context) + about)
    if kind == "value_error":
        return Problem(key, str(context.get("error", error["msg"])), value, about.strip(" ()"))
    fault = "not a finite number" if kind == "finite_number" else "wrong type"
    spelled = str(value).lower() if kind.startswith("bool") else ""
    near = spelled if spelled in ("true", "false") else ""
    begun = kind.replace("model", "dict")  # such as dict_type, int_from_float, string_type
    word = next((word for type_, word in WORDS.items() if begun.startswith(type_.__name__)), None)
    return Problem(key, fault, value, (word or _words(info)) + about, near)


def _key(loc: tuple[Any, ...], data: object) -> Key:
    """Return the location without union tags."""
    key: list[str | int] = []
    tagged = False  # whether this section's tag has already been left out
    for part in loc:
        if part == "[key]" or (isinstance(data, dict) and data.get("kind") == part and not tagged):
            tagged = True
            continue
        if part in FORMS and not (isinstance(data, dict) and part in data):
            continue
        key.append(part)
        data, tagged = value_at(data, (part,)), False
    return tuple(key)


def field_at(
    key: Key, data: object, model: type[Section] = WorldConfig
) -> tuple[FieldInfo | None, type[Section] | None]:
    """Return the field of a key in a model, and the section that contains it."""
    kind: Any = model
    info: FieldInfo | None = None
    parent: type[Section] | None = None
    for part in key:
        kind = type_of(kind, data)
        if is_section(kind):
            parent, info = kind, kind.model_fields.get(str(part))
        kind, data = below(kind, data, part)
    return info, parent


def _words(info: FieldInfo | None) -> str:
    """Describe the values that a field allows."""
    kind = type_of(info.annotation, None) if info else None
    if typing.get_origin(kind) is typing.Literal:
        return listed(map(str, typing.get_args(kind)))
    return WORDS.get(typing.get_origin(kind) or kind, "a table")
