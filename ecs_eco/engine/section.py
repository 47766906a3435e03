"""What all sections of a world file share: strict models and the kinds of numbers."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, PlainSerializer, WrapValidator

LARGEST, SMALLEST = 1e30, 1e-30  # numbers become float32, which ends at 3.4e38 and begins at 1.2e-38


def _in_float32(value: float) -> float:
    if value < SMALLEST:
        raise ValueError(f"too small for float32: it becomes 0; allowed is at least {SMALLEST:g}")
    return value


Real = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
NonNegative = Annotated[float, Field(ge=0.0, le=LARGEST)]
Positive = Annotated[float, Field(gt=0.0, le=LARGEST), AfterValidator(_in_float32)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Count = Annotated[int, Field(ge=1, le=50_000_000)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=40)]
Point = Annotated[list[Real], Field(min_length=2, max_length=3)]

# keywords of formulas cannot be names
RESERVED = frozenset({"and", "or", "not", "if", "else", "in", "is", "lambda", "for", "None", "True", "False"})


class Section(BaseModel):
    """A section of the file: unknown keys are refused, true is not a number,
    and nothing changes after loading."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)


def quantity(text: str, unit: str, default: Any = ..., **limits: Any) -> Any:
    """A field of a section with its description and its unit ("1": a pure number)."""
    return Field(default, description=f"{text} [{unit}]", json_schema_extra={"unit": unit}, **limits)


def about(text: str, default: Any = ..., **limits: Any) -> Any:
    """A field of a section that has no unit: a name, a choice, a table."""
    return Field(default, description=text, **limits)


def is_absent(value: Any) -> bool:
    """Whether a value is None, false or an empty list: with `exclude_if` it is then left out of what is
    written, so that worlds without it have the hash and the digests that they had before there was such a
    key."""
    return value is None or value is False or value == []


def is_empty(value: Any) -> bool:
    """Whether a value is 0 or a list without entries: `exclude_if` as with `is_absent`."""
    return not value


def table(text: str, factory: Any) -> Any:
    """A section or list that may be left out, and its default factory."""
    return Field(default_factory=factory, description=text)


def function_name(function: Any) -> str:
    """ "module:name" of a function, a class or a system; a text stays as it is."""
    if isinstance(function, str):
        return function
    from ecs_eco.engine.code import public_module

    thing = function if hasattr(function, "__qualname__") else type(function)
    return f"{public_module(thing.__module__)}:{thing.__qualname__}"


def _is_code(value: Any) -> bool:
    return callable(value) or callable(getattr(value, "process", None))


class NamesCode:
    """Marks a type of field whose text may name code: `names_in` finds them all."""


OF_CODE = (
    NamesCode(),
    WrapValidator(lambda value, check: value if _is_code(value) else check(value)),
    PlainSerializer(lambda value, info: function_name(value) if info.mode == "json" else value),
)
Function = Annotated[str, Field(pattern=r"^[A-Za-z_][\w.]*:[A-Za-z_]\w*$"), *OF_CODE]
"""In a file "module:name"; from Python also the function itself."""
CodeEntry = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*$",
                                 max_length=200)]
"""A file beside the world, "sir.py", or an installed module, "mypackage.ecology"."""
