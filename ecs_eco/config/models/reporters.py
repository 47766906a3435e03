"""Reporters: user-defined measurements of a world, each a formula over components or a function of the
world."""

import re
from typing import Annotated, Any

from pydantic import Discriminator, PlainSerializer, Tag, ValidatorFunctionWrapHandler, WrapValidator

from ecs_eco.inputs.section import NamesCode, Use, as_written

COLUMNS = frozenset(
    {
        "tick",
        "species",
        "n",
        "births",
        "deaths",
        "refused",
        "energy_mean",
        "happiness_mean",
        "depth_mean",
        "stock_before",
        "endowed",
        "taken_in",
        "burnt",
        "given",
        "lost",
        "stock_after",
    }
)
"""Columns that every series has or may have; reporters cannot have these names."""
DIED = "died: "
"""Prefix of the series columns that count deaths by cause."""
EATEN = "eaten: "
"""Prefix of the series columns for the energy that a species gained by eating another [energy]."""


def is_reporter(column: str) -> bool:
    """Return whether a column of a series belongs to a reporter."""
    return column not in COLUMNS and not column.startswith((DIED, EATEN))


def _known(value: object, check: ValidatorFunctionWrapHandler) -> Any:
    if callable(value):
        return value
    text = check(value)
    if isinstance(text, str) and ":" in text and not re.fullmatch(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*", text):
        raise ValueError("expected a formula or module:name")
    return text


Reporter = Annotated[
    Annotated[str, Tag("word")] | Annotated[Use, Tag("with")],
    Discriminator(lambda value: "with" if isinstance(value, dict | Use) else "word"),
    NamesCode(),
    WrapValidator(_known),
    PlainSerializer(lambda value, info: as_written(value, info.mode == "json")),
]
