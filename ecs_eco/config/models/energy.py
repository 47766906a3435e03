"""The energy of an organism: its budget and the costs of movement."""

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
    quantity,
)


class Metabolism(Section, change=FREE):
    """The energy budget of an organism; each world defines its own unit of energy."""

    energy: NonNegative = quantity(
        "initial energy of founders, and of newborns that get none from parents",
        "energy",
        1.0,
        own="only founders start with it; newborns with parents get reproduction.energy_given",
    )
    energy_spread: Share | None = quantity(
        "founders and immigrants start with `energy` times a factor drawn uniformly from 1 − energy_spread "
        "to 1 + energy_spread, but at most energy_max; 0: all start with the same energy; default: 0.25 for "
        "a species with a nervous system, so that organisms do not all starve at once, otherwise 0",
        "1",
        omit=True,
        own=PARENTLESS,
    )
    energy_max: Positive = quantity("maximum energy that an organism can store", "energy", 1.0, own=True)
    basal: NonNegative = quantity("basal metabolic rate", "energy/s", 0.0, own=True)
    photosynthesis: NonNegative = quantity(
        "energy gained by photosynthesis in full light",
        "energy/s",
        0.0,
        own=Column("Growth", "growth"),
        former="growth",
    )
    handling_time: NonNegative = quantity(
        "time after a meal before the next meal can begin", "s", 0.0, own=True, former="digestion"
    )
    torpor: bool = about(
        "whether it enters torpor when no energy is left: it burns nothing, does not move and does not mate "
        "until it gains energy again; otherwise its energy falls below 0, with consequences as in `lethal`",
        False,
        omit=True,
    )


class Locomotion(Section, change=FREE, own=True):
    """Gaits, their costs, and turning."""

    speed: dict[Name, NonNegative] = quantity("speed of each gait", "m/s", min_length=1)
    cost: dict[Name, NonNegative] = quantity("energy burned in each gait", "energy/s", {})
    turn: NonNegative = quantity("turning rate", "rad/s", 0.0)
    climb: NonNegative = quantity("vertical speed in a volume, the same in all gaits", "m/s", 0.0)
    pitch: Annotated[float, Field(ge=0, le=math.pi / 2)] = quantity(
        "angle at which it swims up or down in a volume at the speed of its gait; used instead of climb",
        "rad",
        0.0,
    )
    drag: NonNegative = quantity(
        "rate at which drag brings its speed to the gait's speed; 0: immediately", "1/s", 0.0
    )
