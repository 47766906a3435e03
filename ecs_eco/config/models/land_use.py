"""What people do with land and sea all the time: fishing, felling, planting, sowing and reaping."""

from fractions import Fraction
from functools import lru_cache
from typing import Annotated, Literal

from pydantic import Field

from ecs_eco.config.models.interventions import REGION, Region, Tick
from ecs_eco.engine.section import (
    ANEW,
    FREE,
    Change,
    Count,
    Name,
    NonNegative,
    Positive,
    Section,
    Share,
    about,
    quantity,
)

Season = Annotated[list[Share], Field(min_length=2, max_length=2)]


class Use(Section, change=FREE):
    """Where and when something is done, at the start of a tick, after interventions."""

    species: Name = about("a species or an object type", change=ANEW)
    region: Region | None = quantity(f"in {REGION}; absent: everywhere", "m", None)
    at: Tick = quantity("the first tick", "ticks", 0)
    until: Tick | None = quantity("the last tick; absent: to the end of the run", "ticks", None)
    period: Positive | None = quantity("length of a year, for season and quota", "s", None)
    season: Season | None = about("from which share of each year to which; absent: all the year", None)

    def active(self, tick: int, dt: float) -> bool:
        """Whether it is done in a tick of dt [s]."""
        if tick < self.at or (self.until is not None and tick > self.until):
            return False
        if self.season is None or self.period is None:
            return True
        (first, last), share = map(exact, self.season), tick / exact(self.period / dt) % 1
        return first <= share < last if first < last else share >= first or share < last

    def year(self, tick: int, dt: float) -> int:
        """The number of the year that a tick of dt [s] is in, from 0; always 0 without years."""
        return 0 if self.period is None else tick // exact(self.period / dt)


@lru_cache(256)
def exact(value: float) -> Fraction:
    """The ratio that a value stands for, 1/5 for 0.2: rounding of floats would give years unequal ticks."""
    return Fraction(value).limit_denominator(10**6)


class Harvest(Use):
    """Organisms or objects are taken at a rate, up to a quota: fishing, felling, hunting, reaping."""

    kind: Annotated[Literal["harvest"], Change(ANEW)]
    rate: NonNegative = quantity(
        "share of those there that is taken in a second (the mortality F of Baranov 1918)", "1/s"
    )
    quota: Count | None = quantity(
        "most that is taken in a year, or ever where there are no years; absent: no limit", "1", None
    )
    least: NonNegative | None = quantity(
        "least radius of a body that is taken, as of a mesh; absent: any", "m", None
    )
    most: NonNegative | None = quantity("greatest radius of a body that is taken; absent: any", "m", None)
    cause: Annotated[str, Field(min_length=1, max_length=60)] = about("cause of death", "harvested")


class Plant(Use):
    """Newcomers are brought at a rate, in the state of founders: planting, sowing, stocking."""

    kind: Annotated[Literal["plant"], Change(ANEW)]
    rate: NonNegative = quantity("how many in a second", "1/s")
    up_to: Count | None = quantity("number there beyond which none are brought; absent: no limit", "1", None)


AnyUse = Annotated[Harvest | Plant, Field(discriminator="kind")]
