"""The course of a life: fertility with age and season."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ecs_eco.engine.section import NonNegative, Positive, Section, Share, quantity

Season = Annotated[float, Field(gt=0, le=1)]


class Breeding(Section):
    """How fertility depends on age and season: `fertility` is its height, reached at the prime, in season.

    With age it follows a beta curve from maturity to the end; where the prime is a third of the way it is
    Brass's polynomial (Brass 1975), which fits mammals well (Gage 2001). Over the year it follows a von Mises
    curve, a normal one bent into a circle.
    """

    maturity: NonNegative = quantity("age from which it is fertile", "s", 0.0)
    prime: Positive | None = quantity(
        "age at which it is most fertile; absent: a third of the way from maturity to the end; "
        "without an end: at maturity", "s", None
    )
    end: Positive | None = quantity("age at which fertility ends; absent: it does not fall with age, "
                                    "and rises in proportion to age from maturity to the prime", "s", None)
    season: Share | None = quantity("time of the year when it is most fertile: 0 is the spring equinox, 0.25 "
                                    "midsummer; absent: it breeds all year; the world needs a year", "1",
                                    None)
    width: Season = quantity("length of the season: its standard deviation, as a share of a year", "1", 0.1)

    def age_of_prime(self) -> float:
        """The age of the prime [s]."""
        if self.prime is not None:
            return self.prime
        return self.maturity if self.end is None else self.maturity + (self.end - self.maturity) / 3


