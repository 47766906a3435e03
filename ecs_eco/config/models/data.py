"""Measurements from outside that a world is compared with."""

from typing import Annotated, Literal

from pydantic import Field

from ecs_eco.engine.section import Positive, Section, about, is_absent, quantity

STATISTICS = ("period", "lag", "amplitude", "mean")

Text = Annotated[str, Field(min_length=1, max_length=200)]


class Data(Section):
    """An outside series: measurements that reports show beside a run, and that a search can fit."""

    file: Annotated[str, Field(min_length=1, max_length=1000)] = about(
        "a CSV beside the world file: a head with the names of the columns, then a row for each time, evenly "
        "spaced"
    )
    time: Text | None = about("the column of the times; absent: the first one", None, exclude_if=is_absent)
    unit: Text | None = about(
        'unit of the times, as "year"; absent: the name of their column', None, exclude_if=is_absent
    )
    columns: dict[Text, Text] = Field(
        default_factory=dict,
        max_length=64,
        description="column = the species, or the reporter, that it "
        "is compared with; columns that are not here are compared with what they are named as",
    )
    ticks: Positive | None = quantity(
        "how long a unit of the times lasts in the world; absent: not known, and lags and amplitudes are "
        "compared period by period",
        "ticks",
        None,
        exclude_if=is_absent,
    )
    statistics: Annotated[list[Literal["period", "lag", "amplitude", "mean"]], Field(min_length=1)] = about(
        "what a search with the objective data compares: period of the cycle (where `ticks` is given), lags "
        "between the columns, amplitude and mean of each (mean where the units are the same)",
        ["period", "lag", "amplitude"],
    )
