"""The energy of an organism: what it burns, and moves by."""

import math
from typing import Annotated

from pydantic import Field

from ecs_eco.inputs.section import (
    FREE,
    PARENTLESS,
    Column,
    Name,
    NonNegative,
    Positive,
    Section,
    Share,
    about,
    is_absent,
    quantity,
)


class Metabolism(Section, change=FREE):
    """The energy budget of one organism; the unit of energy is the world's own."""

    energy: NonNegative = quantity(
        "energy at the start and of a newborn without parent",
        "energy",
        1.0,
        own="founders bring it along; of those with parents it is reproduction.energy_given",
    )
    energy_spread: Share | None = quantity(
        "founders and immigrants have 1 − energy_spread to 1 + energy_spread times that energy, drawn evenly "
        "and at most energy_max; 0: all have the same; absent: 0.25 for a species with a nervous system, so "
        "that not all starve at once, 0 for others",
        "1",
        None,
        exclude_if=is_absent,
        own=PARENTLESS,
    )
    energy_max: Positive = quantity("most energy that an organism can hold", "energy", 1.0, own=True)
    basal: NonNegative = quantity("energy burned by living", "energy/s", 0.0, own=True)
    photosynthesis: NonNegative = quantity(
        "energy made in full light", "energy/s", 0.0, own=Column("Growth", "growth"), former="growth"
    )
    handling_time: NonNegative = quantity(
        "time after a meal without another", "s", 0.0, own=True, former="digestion"
    )
    torpor: bool = about(
        "whether it falls into torpor where no energy is left: it burns nothing, stands "
        "still and does not mate until it has eaten or grown; else energy falls below 0, "
        "and `lethal` says what that means",
        False,
        exclude_if=is_absent,
    )


class Locomotion(Section, change=FREE, own=True):
    """Gaits, their costs, and how fast it turns."""

    speed: dict[Name, NonNegative] = quantity("speed of each gait", "m/s", min_length=1)
    cost: dict[Name, NonNegative] = quantity("energy burned in each gait", "energy/s", {})
    turn: NonNegative = quantity("rate of turning", "rad/s", 0.0)
    climb: NonNegative = quantity("speed up and down in a volume, the same in all gaits", "m/s", 0.0)
    pitch: Annotated[float, Field(ge=0, le=math.pi / 2)] = quantity(
        "angle by which it swims up or down in a volume, at the speed of its gait; instead of climb",
        "rad",
        0.0,
    )
    drag: NonNegative = quantity(
        "rate at which speed approaches that of the gait, by drag; 0: at once", "1/s", 0.0
    )
