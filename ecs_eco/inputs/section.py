"""What all sections of a world file share: strict models and the kinds of numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, NamedTuple, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    PlainSerializer,
    Tag,
    WrapValidator,
    create_model,
)

from ecs_eco.inputs.code import public_module

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


# what to do instead of changing a value in a living world
FREE = ""  # it may change
ANEW = "build a world with it and run it from the start"
SWITCH = '; or an intervention of kind "switch"'
NUMBERS = 'an intervention of kind "add" or "cull"'
FENCE = 'an intervention of kind "fence"'
SHAPE = "weights and columns have their shapes from it: build a world with it"

# why a number cannot be an organism's own
COLUMN = "COLUMN"  # it can: it has a column of a component, and a trait in config/traits.py
POPULATION = "it counts organisms: no single one has it"
PARENTLESS = "it is about organisms without parents, who have no gene of anybody"
LETTERS = "it says how letters are read and copied: a gene that changed it would be read differently"
MATTER = "it is matter, which comes from parents, food and surroundings, not from letters"
CHEMISTRY = "a reaction has the same proportions in every body"
FORM = "all of a species have one shape, which body.radius makes larger or smaller as a whole"
WIDTH = "it is the width of a column or of a network's input, which all of the species share"


@dataclass(frozen=True)
class Change:
    """What to do instead of changing a field in a living world, FREE where it may change; and of the entries
    of a table, where that differs."""

    instead: str | None = None
    entries: str | None = None


class Column(NamedTuple):
    """The component whose field of the number's name holds an organism's own value."""

    component: str


@dataclass(frozen=True)
class Own:
    """Whether a gene may code for a number: True (its system reads it by `own_value`), a `Column`, COLUMN, or
    the reason why not."""

    own: bool | str | Column


class Section(BaseModel):
    """A section of the file: unknown keys are refused, true is not a number, and nothing changes after
    loading.

    `change` and `own` of a subclass are those of its fields that declare none. Without `change` fields follow
    the field that holds the section.
    """

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)
    marks: ClassVar[tuple[Change, Own | None]] = (Change(), None)

    def __init_subclass__(
        cls, change: str | None = None, own: bool | str | Column | None = None, **other: Any
    ) -> None:
        super().__init_subclass__(**other)
        cls.marks = (
            cls.marks[0] if change is None else Change(change),
            cls.marks[1] if own is None else Own(own),
        )


def kinds_of(section: object) -> tuple[Any, ...]:
    """Return the values of `kind` by which unions know a section."""
    info = getattr(section, "model_fields", {}).get("kind")
    return get_args(info.annotation) if info else ()


def with_keyword(name: str, kind: object, declared: object) -> Any:
    """Return a section with one field whose name is a keyword of Python: no class body could give it."""
    fields: dict[str, Any] = {name: (kind, declared)}
    return create_model("_Keyword", __base__=Section, **fields)


def quantity(
    text: str,
    unit: str,
    default: object = ...,
    *,
    change: str | None = None,
    own: bool | str | Column | None = None,
    **limits: Any,
) -> Any:
    """A field of a section with its description and its unit ("1": a pure number)."""
    return about(
        f"{text} [{unit}]", default, change=change, own=own, json_schema_extra={"unit": unit}, **limits
    )


def about(
    text: str,
    default: object = ...,
    *,
    change: str | None = None,
    entries: str | None = None,
    own: bool | str | Column | None = None,
    **limits: Any,
) -> Any:
    """A field of a section that has no unit: a name, a choice, a table."""
    field = Field(default, description=text, **limits)
    if change is not None or entries is not None:
        field.metadata.append(Change(change, entries))
    if own is not None:
        field.metadata.append(Own(own))
    return field


def is_absent(value: object) -> bool:
    """Whether a value is None, false or an empty list: with `exclude_if` it is then left out of what is
    written, so that worlds without it have the hash and the digests that they had before there was such a
    key."""
    return value is None or value is False or value == []


def is_empty(value: object) -> bool:
    """Whether a value is 0 or a list without entries: `exclude_if` as with `is_absent`."""
    return not value


def table(text: str, factory: Callable[[], object], **declared: Any) -> Any:
    """A section or list that may be left out, and its default factory."""
    return about(text, default_factory=factory, **declared)


def function_name(function: object) -> str:
    """ "module:name" of a function, a class or a system; a text stays as it is."""
    if isinstance(function, str):
        return function
    if isinstance(function, Use):
        return function_name(function.use)
    thing = function if hasattr(function, "__qualname__") else type(function)
    return f"{public_module(thing.__module__)}:{thing.__qualname__}"


def as_written(value: object, json: bool) -> Any:
    """Return what stands for code in a file, with JSON types or as it was handed over."""
    if isinstance(value, Use):
        return {"use": as_written(value.use, json), **value.parameters}
    return function_name(value) if json else value


def _is_code(value: object) -> bool:
    return callable(value) or callable(getattr(value, "process", None))


class NamesCode:
    """Marks a type of field whose text may name code: `names_in` finds them all."""


OF_CODE = (
    NamesCode(),
    WrapValidator(lambda value, check: value if _is_code(value) else check(value)),
    PlainSerializer(lambda value, info: as_written(value, info.mode == "json")),
)
NAMED = r"^[A-Za-z_][\w.]*:[A-Za-z_]\w*$"
Function = Annotated[str, Field(pattern=NAMED), *OF_CODE]
"""In a file "module:name"; from Python also the function itself."""


class Use(Section):
    """A function or class of your own with its parameters, the other keys: those of the function after the
    arguments that it is called with, or those of the constructor."""

    model_config = ConfigDict(extra="allow")

    use: Function = about("module:name of the function or class")

    @property
    def parameters(self) -> dict[str, Any]:
        """The parameters that are given, by name."""
        return dict(self.__pydantic_extra__ or {})


WithParameters = Annotated[
    Annotated[str, Field(pattern=NAMED), Tag("word")] | Annotated[Use, Tag("with")],
    Discriminator(lambda value: "with" if isinstance(value, dict | Use) else "word"),
    *OF_CODE,
]
"""In a file "module:name", or { use = "module:name", … } with parameters; from Python also the function."""
CodeEntry = Annotated[
    str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*$", max_length=200)
]
"""A file beside the world, "sir.py", or an installed module, "mypackage.ecology"."""
