"""Parameters of user-defined functions and classes: those after the call's arguments, typed by annotations or
defaults."""

from __future__ import annotations

import inspect
import math
import typing
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from pydantic import ConfigDict, TypeAdapter, ValidationError
from pydantic.errors import PydanticUserError

from ecs_eco.engine.errors import Problem, listed, nearest

PLAIN = (bool, int, float, str)


def applied(thing: Callable[..., Any], given: Mapping[str, object]) -> Any:
    """Return an instance of a class, or a function with these parameters filled in."""
    return thing(**given) if isinstance(thing, type) else partial(thing, **given)


def problems_of_parameters(
    thing: Callable[..., Any], given: Mapping[str, object], n: int, key: tuple[str | int, ...]
) -> list[Problem]:
    """Return the problems (unknown names, wrong types, missing parameters) with the parameters of a function
    or class that is called with `n` other arguments. The function is not called."""
    try:
        every = list(inspect.signature(thing).parameters.values())
    except (TypeError, ValueError):  # its signature is unknown
        return []
    named = [p for p in every[n:] if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
    hints, known = _hints(thing), {p.name: p for p in named}
    anything = any(p.kind is p.VAR_KEYWORD for p in every)
    problems = [
        Problem((*key, p.name), "is missing", allowed=_in_words(p, hints))
        for p in named
        if p.default is p.empty and p.name not in given
    ]
    for name, value in given.items():
        if name in known:
            if fault := _fault(value, known[name], hints):
                problems.append(
                    Problem((*key, name), "wrong value", value, f"{fault} ({_in_words(known[name], hints)})")
                )
        elif not anything:
            fault = f"not a parameter of {getattr(thing, '__name__', 'it')}"
            allowed = listed(_in_words(p, hints) for p in named) if named else "none: it takes no parameters"
            problems.append(Problem((*key, name), fault, value, allowed, nearest(name, known)))
    return problems


def _hints(thing: object) -> dict[str, Any]:
    """Return the annotations of a function's parameters; return an empty dict if they cannot be resolved."""
    try:
        return typing.get_type_hints(
            vars(thing).get("__init__", thing) if isinstance(thing, type) else thing, include_extras=True
        )
    except Exception:  # names that only type checkers know
        return {}


def _kind(parameter: inspect.Parameter, hints: Mapping[str, Any]) -> Any:
    """Return a parameter's type, from its annotation or else its default; None if it has neither."""
    if parameter.name in hints:
        return hints[parameter.name]
    kind = type(parameter.default)
    return (float if kind is int else kind) if kind in PLAIN else None


def _in_words(parameter: inspect.Parameter, hints: Mapping[str, Any]) -> str:
    kind = _kind(parameter, hints)
    word = "" if kind is None else f": {getattr(kind, '__name__', kind)}"
    return f"{parameter.name}{word}" + (
        "" if parameter.default is parameter.empty else f" = {parameter.default!r:.30}"
    )


def _fault(value: object, parameter: inspect.Parameter, hints: Mapping[str, Any]) -> str:
    """Return a description of the expected value if a value is wrong, otherwise ""."""
    if not _is_data(value):
        return "a TOML value: a finite number, a string, true, false, or a list or table of these"
    kind = _kind(parameter, hints)
    if kind is None:
        return ""
    check = _checker(kind)
    return "" if check is None else check(value)


def _checker(kind: type[Any]) -> Callable[[Any], str] | None:
    """Return a function that reports why a value has the wrong type; None if the type cannot be checked."""
    try:
        adapter: TypeAdapter[Any] = TypeAdapter(kind, config=ConfigDict(strict=True, allow_inf_nan=False))
    except (PydanticUserError, TypeError, NameError):
        return None

    def check(value: object) -> str:
        try:
            adapter.validate_python(value)
        except ValidationError as error:
            return error.errors()[0]["msg"].removeprefix("Input should be ")
        return ""

    return check


def _is_data(value: object) -> bool:
    if isinstance(value, list):
        return all(_is_data(v) for v in value)
    if isinstance(value, Mapping):
        return all(isinstance(k, str) and _is_data(v) for k, v in value.items())
    return isinstance(value, bool | int | str) or (isinstance(value, float) and math.isfinite(value))
