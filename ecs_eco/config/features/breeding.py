"""Breeding: fertility depends on age and season."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field

from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.engine.errors import Problem
from ecs_eco.engine.section import (
    COLUMN,
    FREE,
    NonNegative,
    Positive,
    Section,
    Share,
    about,
    is_absent,
    quantity,
)

Season = Annotated[float, Field(gt=0, le=1)]


class Breeding(Section, change=FREE, own=COLUMN):
    """How fertility depends on age and season: `fertility` is its height, reached at the prime, in season.

    With age it follows a beta curve from maturity to the end; where the prime is a third of the way it is
    Brass's polynomial (Brass 1975), which fits mammals well (Gage 2001). Over the year it follows a von Mises
    curve, a normal one bent into a circle.
    """

    maturity: NonNegative = quantity("age from which it is fertile", "s", 0.0)
    prime: Positive | None = quantity(
        "age at which it is most fertile; absent: a third of the way from maturity to the end; "
        "without an end: at maturity",
        "s",
        None,
    )
    end: Positive | None = quantity(
        "age at which fertility ends; absent: it does not fall with age, "
        "and rises in proportion to age from maturity to the prime",
        "s",
        None,
    )
    season: Share | None = quantity(
        "time of the year when it is most fertile: 0 is the spring equinox, 0.25 "
        "midsummer; absent: it breeds all year; the world needs a year",
        "1",
        None,
    )
    width: Season = quantity("length of the season: its standard deviation, as a share of a year", "1", 0.1)

    def age_of_prime(self) -> float:
        """The age of the prime [s]."""
        if self.prime is not None:
            return self.prime
        return self.maturity if self.end is None else self.maturity + (self.end - self.maturity) / 3


class Seasons(Feature, after="fertility"):
    """Fertility follows age and season: system `Mature`, component `Breeding`."""

    breeding: Breeding | None = about(
        "how fertility depends on age and season; absent: it stays", None, exclude_if=is_absent
    )

    @staticmethod
    def problems(species: Seasons, config: WorldSections, key: Key) -> Iterator[Problem]:
        """Yield ages that are not in order, and a season without a year."""
        way, at = species.breeding, (*key, "breeding")
        if way is None:
            return
        if way.end is not None and way.end <= way.maturity:
            yield Problem((*at, "end"), "not after maturity", way.end, f"more than {way.maturity:g} s")
        elif way.prime is not None and not (way.maturity < way.prime < (way.end or float("inf"))):
            allowed = f"more than {way.maturity:g} s" + (f", less than {way.end:g} s" if way.end else "")
            yield Problem((*at, "prime"), "not between maturity and end", way.prime, allowed)
        if way.season is not None and config.year is None and (config.sun is None or config.sun.year is None):
            allowed = "a section year, or sun.year; or no season"
            yield Problem((*at, "season"), "there is no year for it", way.season, allowed)
