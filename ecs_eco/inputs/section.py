"""The common base of all sections of a world file: strict models, and number types."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from operator import eq
from typing import Annotated, Any, ClassVar, NamedTuple

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

from ecs_eco.engine.submodel import Submodel
from ecs_eco.inputs.code import public_module

LARGEST, SMALLEST = 1e30, 1e-30  # numbers become float32, which ranges from 1.2e-38 to 3.4e38


def _in_float32(value: float) -> float:
    if value < SMALLEST:
        raise ValueError(f"too small for float32: it becomes 0; expected at least {SMALLEST:g}")
    return value


Real = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
NonNegative = Annotated[float, Field(ge=0.0, le=LARGEST)]
Positive = Annotated[float, Field(gt=0.0, le=LARGEST), AfterValidator(_in_float32)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Count = Annotated[int, Field(ge=1, le=50_000_000)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=40)]
Pair = Annotated[list[Real], Field(min_length=2, max_length=2)]
Point = Annotated[list[Real], Field(min_length=2, max_length=3)]

# keywords of formulas, which cannot be names
RESERVED = frozenset({"and", "or", "not", "if", "else", "in", "is", "lambda", "for", "None", "True", "False"})


# alternatives to changing a value in a live world
FREE = ""  # it may change
ANEW = "build a world with it and run it from the start"
SWITCH = '; or an intervention of kind "switch"'
NUMBERS = 'an intervention of kind "add" or "cull"'
FENCE = 'an intervention of kind "fence"'
SHAPE = "it sets the shapes of weights and columns: build a world with it"

# why a number cannot be heritable
COLUMN = "COLUMN"  # it can: it has a component column, and a trait in config/traits.py
POPULATION = "it counts organisms, so no single organism has it"
PARENTLESS = "it concerns organisms without parents, which inherit no genes"
LETTERS = "it determines how genomes are read and copied: a gene for it would change its own meaning"
MATTER = "it is matter, which comes from parents, food and surroundings, not from genes"
CHEMISTRY = "a reaction has the same proportions in every body"
FORM = "all members of a species have the same shape, which body.radius scales as a whole"
WIDTH = "it is the width of a column or of a network's input, which all members of the species share"


@dataclass(frozen=True)
class Change:
    """The alternative to changing a field in a live world, or FREE if the field may change; `entries` is the
    alternative for a table's entries, if different."""

    instead: str | None = None
    entries: str | None = None


class Column(NamedTuple):
    """The component that stores each organism's own value, in `field` or in a field named like the number."""

    component: str
    field: str = ""


@dataclass(frozen=True)
class Own:
    """Whether a gene may code for a number: True, a `Column`, COLUMN, or the reason why not."""

    own: bool | str | Column


class Section(BaseModel):
    """A section of a world file: a strict, immutable pydantic model that rejects unknown keys.

    Notes
    -----
    The class keywords `change` and `own` apply the `about` arguments of the same names to all fields of a
    subclass.

    Examples
    --------
    >>> from ecs_eco.config import FREE, NonNegative, Section, quantity
    >>> class Cough(Section, change=FREE):
    ...     rate: NonNegative = quantity("coughs per second", "1/s", 0.1)
    >>> Cough(rate=0.5).rate
    0.5
    """

    model_config = ConfigDict(
        extra="forbid",
        strict=True,
        allow_inf_nan=False,
        frozen=True,
        populate_by_name=True,
        loc_by_alias=False,
    )
    marks: ClassVar[tuple[Change, Own | None]] = (Change(), None)
    submodel: ClassVar[Submodel | None] = None
    """The section's part of the world's description (`ecs-eco describe`)."""

    def __init_subclass__(
        cls, change: str | None = None, own: bool | str | Column | None = None, **other: Any
    ) -> None:
        super().__init_subclass__(**other)
        cls.marks = (
            cls.marks[0] if change is None else Change(change),
            cls.marks[1] if own is None else Own(own),
        )


def with_keyword(name: str, kind: object, declared: object) -> Any:
    """Return a section with one field whose name is a Python keyword."""
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
    """Declare a key whose value is a quantity with a unit.

    Parameters
    ----------
    text : str
        Description, shown in the reference and in editors.
    unit : str
        Unit, such as "m/s"; "1" for a pure number.
    default : object, optional
        Default value; without it, the key is required.
    change : str, optional
        As in `about`.
    own : bool or str, optional
        As in `about`.
    **limits
        Other arguments, passed to `pydantic.Field`.

    Returns
    -------
    pydantic.fields.FieldInfo

    Examples
    --------
    >>> from ecs_eco.config import Positive, Section, quantity
    >>> class Song(Section):
    ...     pitch: Positive = quantity("fundamental frequency", "Hz", 440.0)
    >>> Song.model_fields["pitch"].description
    'fundamental frequency [Hz]'
    """
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
    former: str | None = None,
    omit: bool = False,
    **limits: Any,
) -> Any:
    """Declare a key without a unit, such as a name, a choice or a table.

    Parameters
    ----------
    text : str
        Description, shown in the reference and in editors.
    default : object, optional
        Default value; without it, the key is required.
    change : str, optional
        `FREE` if the value may change in a live world, otherwise the alternative, such as `ANEW`; default:
        the same as for the key that contains the section.
    entries : str, optional
        As `change`, for a table's entries, if different.
    own : bool or str, optional
        True if a gene may code for the number, otherwise the reason why not.
    former : str, optional
        A former name of the key, which is still accepted.
    omit : bool, default False
        Whether files omit the key if it has its default (None unless given), so that worlds without the
        key keep their previous hash and digests.
    **limits
        Other arguments, passed to `pydantic.Field`.

    Returns
    -------
    pydantic.fields.FieldInfo

    Examples
    --------
    >>> from ecs_eco.config import Section, about
    >>> class Song(Section):
    ...     dialect: str = about("name of the dialect", "northern")
    >>> Song().dialect
    'northern'
    """
    if omit:
        default = None if default is ... and "default_factory" not in limits else default
        limits["exclude_if"] = partial(eq, limits.get("default_factory", lambda: default)())
    field = Field(default, description=text, alias=former, **limits)
    if change is not None or entries is not None:
        field.metadata.append(Change(change, entries))
    if own is not None:
        field.metadata.append(Own(own))
    return field


def table(text: str, factory: Callable[[], object], **declared: Any) -> Any:
    """Declare an optional section or list with a default factory."""
    return about(text, default_factory=factory, **declared)


def function_name(function: object) -> str:
    """Return "module:name" for a function, a class or a system; return a string unchanged."""
    if isinstance(function, str):
        return function
    if isinstance(function, Use):
        return function_name(function.use)
    thing = function if hasattr(function, "__qualname__") else type(function)
    return f"{public_module(thing.__module__)}:{thing.__qualname__}"


def as_written(value: object, json: bool) -> Any:
    """Return code in the form used in files (`json`), or as the object that was passed."""
    if isinstance(value, Use):
        return {"use": as_written(value.use, json), **value.parameters}
    return function_name(value) if json else value


def _is_code(value: object) -> bool:
    return callable(value) or callable(getattr(value, "process", None))


class NamesCode:
    """Marks a field type whose text may name code; `names_in` finds all such fields."""


OF_CODE = (
    NamesCode(),
    WrapValidator(lambda value, check: value if _is_code(value) else check(value)),
    PlainSerializer(lambda value, info: as_written(value, info.mode == "json")),
)
NAMED = r"^[A-Za-z_][\w.]*:[A-Za-z_]\w*$"
Function = Annotated[str, Field(pattern=NAMED), *OF_CODE]
"""In a file, "module:name"; from Python, the function itself or its name."""


class Use(Section):
    """Your own function or class; all other keys are its parameters (for a function, those after the call's
    arguments)."""

    model_config = ConfigDict(extra="allow")

    use: Function = about("module:name of the function or class")

    @property
    def parameters(self) -> dict[str, Any]:
        """The given parameters by name."""
        return dict(self.__pydantic_extra__ or {})


WithParameters = Annotated[
    Annotated[str, Field(pattern=NAMED), Tag("word")] | Annotated[Use, Tag("with")],
    Discriminator(lambda value: "with" if isinstance(value, dict | Use) else "word"),
    *OF_CODE,
]
"""In a file, "module:name", or { use = "module:name", … } with parameters; from Python, also the function."""
CodeEntry = Annotated[
    str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*$", max_length=200)
]
"""A file next to the world, "sir.py", or an installed module, "mypackage.ecology"."""
