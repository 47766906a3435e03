"""What the viewer's page offers first: the knobs of a world. Runs ignore them, and no hash knows of them."""

from typing import Annotated

from pydantic import Field

from ecs_eco.engine.section import Real, Section, about, quantity, table


class Knob(Section):
    """A number that the page offers as a slider."""

    key: str = about("dotted key of a number that may change in a run, as species.deer.metabolism.basal")
    label: Annotated[str, Field(min_length=1, max_length=60)] | None = about(
        "what it is called in the page; absent: its key", None
    )
    min: Real = quantity("value at the left end of the slider", "unit of the key")
    max: Real = quantity("value at the right end", "unit of the key")
    unit: Annotated[str, Field(max_length=20)] | None = about("its unit; absent: that of its key", None)


class Viewer(Section):
    """What the viewer's page offers first: `ecs-eco watch`."""

    knobs: Annotated[list[Knob], Field(max_length=24)] = table(
        "numbers that the page offers as sliders, in this order", list
    )
