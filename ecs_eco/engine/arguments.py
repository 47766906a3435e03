"""Checks of arguments passed from Python, as strict as the checks of files: errors give the name, the value and
the expected values."""

import inspect
import math
import operator
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, TypeVar

from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest

T = TypeVar("T")
SEEDS = 2**63  # the same as in world files


def whole_number(name: str, value: object, least: int = 0, most: int | None = None, unit: str = "") -> int:
    """Return a Python or numpy integer as int.

    Raises TypeError for any other type, including bool, and ValueError if it is out of range.
    """
    allowed = (
        "a whole number"
        + (f" of at least {least}" if most is None else f" from {least} to {most}")
        + (f" {unit}" if unit else "")
    )
    try:
        if isinstance(value, bool) or type(value).__name__ in ("bool", "bool_"):
            raise TypeError
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"{name} is {value!r}; expected {allowed}") from None
    if number < least or (most is not None and number > most):
        raise ValueError(f"{name} is {number}; expected {allowed}")
    return number


def optional_number(name: str, value: object, least: int = 0) -> int | None:
    """Return a Python or numpy integer as int, or None. Raises TypeError or ValueError."""
    return None if value is None else whole_number(name, value, least)


def seed_number(value: object, name: str = "seed") -> int:
    """Return a seed as int. Raises TypeError or ValueError."""
    return whole_number(name, value, 0, SEEDS - 1)


def positive(name: str, value: object, unit: str) -> float:
    """Return a finite number above 0 as float.

    Raises TypeError for anything but a number, and ValueError if the number is out of range.
    """
    if isinstance(value, bool | str) or not hasattr(value, "__float__"):
        raise TypeError(f"{name} is {value!r}; expected a finite number of {unit} above 0")
    number = float(value)
    if not (number > 0 and math.isfinite(number)):
        raise ValueError(f"{name} is {value!r}; expected a finite number of {unit} above 0")
    return number


def takes(function: Callable[..., Any], n: int, given: Mapping[str, Any] = MappingProxyType({})) -> str:
    """Return why a function cannot be called with `n` arguments and `given` parameters, or "" if it can. The
    function is not called."""
    try:
        inspect.signature(function).bind(*[None] * n, **given)
    except TypeError as error:
        return f"must accept {n} argument{'s' * (n != 1)}: {error}"
    except ValueError:  # the function's signature is unknown
        return ""
    return ""


def called_with(name: str, value: object, *arguments: str) -> None:
    """Raise TypeError unless a value is None or a function that accepts these arguments."""
    wanted = f"a function that is called with {' and '.join(arguments)}, or None"
    if value is not None and not callable(value):
        raise TypeError(f"{name} is {value!r}; expected {wanted}")
    if value is not None and (fault := takes(value, len(arguments))):
        raise TypeError(f"{name} is {value!r}, which {fault}; expected {wanted}")


def by_species(name: str, value: T, species: Iterable[str], kinds: tuple[type, ...], allowed: str) -> T:
    """Return the value, which is either shared by all species or a dict of values by species. Raises
    ConfigError for an unknown name or a wrong type."""
    known, problems = list(species), []
    pairs = value.items() if isinstance(value, Mapping) else [(None, value)]
    for name_of, item in pairs:
        if name_of is not None and name_of not in known:
            problems.append(
                Problem(
                    (name,),
                    "no such species",
                    str(name_of),
                    listed(known),
                    nearest(str(name_of), known),
                    "argument",
                )
            )
        elif item is not None and not isinstance(item, kinds):
            key = (name,) if name_of is None else (name, str(name_of))
            problems.append(Problem(key, "wrong type", item, allowed, source="argument"))
    if problems:
        raise ConfigError(problems)
    return value
