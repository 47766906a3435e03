"""Life history: fertility depends on age and season, the young grow, and parents feed them."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from ecs_eco.config.features.feature import Cost, Feature, Key, WorldSections
from ecs_eco.engine.errors import Problem
from ecs_eco.inputs.section import COLUMN, FREE, SHAPE, NonNegative, Positive, Section, Share, about, quantity


class Breeding(Section, change=FREE, own=COLUMN):
    """Fertility by age and season; `fertility` is its peak, reached at the prime, in season.

    If `end` is given, it follows a beta curve over age, from maturity to the end; if the prime is a third of
    the way between the two, this is Brass's polynomial (Brass 1975), which fits mammals well (Gage 2001).
    Over the year, it follows a von Mises curve, the circular analog of the normal curve.
    """

    maturity: NonNegative = quantity("age from which it is fertile", "s", 0.0)
    prime: Positive | None = quantity(
        "age of peak fertility; default: a third of the way from maturity to end or, without end, maturity",
        "s",
        None,
    )
    end: Positive | None = quantity(
        "age at which fertility ends; default: never, and fertility rises linearly from maturity to prime",
        "s",
        None,
    )
    season: Share | None = quantity(
        "time of year of peak fertility: 0 is the spring equinox, 0.25 midsummer; default: all year; needs "
        "`year`",
        "1",
        None,
    )
    width: Annotated[float, Field(gt=0, le=1)] = quantity(
        "length of the season: its standard deviation, as a fraction of a year", "1", 0.1
    )

    def age_of_prime(self) -> float:
        """The age of peak fertility [s]."""
        if self.prime is not None:
            return self.prime
        return self.maturity if self.end is None else self.maturity + (self.end - self.maturity) / 3


class Seasons(Feature, after="fertility"):
    """Fertility depends on age and season: system `Mature`, component `Breeding`."""

    breeding: Breeding | None = about("dependence of fertility on age and season; absent: none", omit=True)

    @staticmethod
    def problems(species: "Seasons", config: WorldSections, key: Key) -> Iterator[Problem]:
        way, at = species.breeding, (*key, "breeding")
        if way is None:
            return
        if way.end is not None and way.end <= way.maturity:
            yield Problem((*at, "end"), "not after maturity", way.end, f"more than {way.maturity:g} s")
        elif way.prime is not None and not (way.maturity < way.prime < (way.end or float("inf"))):
            allowed = f"more than {way.maturity:g} s" + (f", less than {way.end:g} s" if way.end else "")
            yield Problem((*at, "prime"), "not between maturity and end", way.prime, allowed)
        if way.season is not None and config.year is None and (config.sun is None or config.sun.year is None):
            allowed = "a `year` section or sun.year, or remove season"
            yield Problem((*at, "season"), "the world has no year", way.season, allowed)


class Growth(Section, change=FREE, own=True):
    """Growth from newborn to adult size; `body` describes adults, and the costs of living scale with mass to
    the power 3/4. Founders and immigrants are adults."""

    law: Literal["von_bertalanffy", "west"] = about(
        "growth law: the cube root (von Bertalanffy 1957) or the fourth root (West, Brown & Enquist 2001) of "
        "the mass approaches the adult's at a constant rate",
        "von_bertalanffy",
    )
    rate: Positive = quantity(
        "growth rate; if adult mass is heritable, for an adult with the mass body.mass", "1/s"
    )
    newborn: Annotated[float, Field(ge=1e-9, le=1)] = quantity(
        "mass of a newborn, as a fraction of the adult's", "1", 0.05
    )
    cost: NonNegative = quantity("energy burned per kilogram of growth", "energy/kg", 0.0)
    reserve: NonNegative = quantity(
        "energy reserve that is not spent on growth; with 0, it spends everything and starves", "energy", 0.0
    )
    pace: NonNegative = quantity(
        "speeds scale with (mass / adult mass) to this power; 0: the young are as fast as adults", "1", 0.0
    )
    store: NonNegative = quantity(
        "metabolism.energy_max scales with (mass / adult mass) to this power; 1: in proportion to the body; "
        "0: the young can store as much as adults. Energy at birth above the limit is kept",
        "1",
        0.0,
        omit=True,
    )


class Growing(Feature, after="breeding"):
    """The young grow: system `GrowUp`, component `Stature`."""

    growth: Growth | None = about(
        "growth of the young; absent: they are born at adult size", omit=True, change=SHAPE
    )

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        way, most = species.growth, species.metabolism.energy_max
        if way is not None and way.cost and way.reserve >= most:
            fault = "at least energy_max: the young would not grow"
            yield Problem((*key, "growth", "reserve"), fault, way.reserve, f"less than {most:g}")


class Care(Section, change=FREE, own=True):
    """Feeding of the young at their parents' expense.

    With the `nurse` action, a parent feeds them when it decides to; otherwise it feeds them whenever possible.
    """

    rate: Positive = quantity("maximum energy given to each offspring", "energy/s")
    age_max: Positive = quantity("age until which the young are fed", "s", former="until")
    reach: NonNegative = quantity("maximum distance between the bodies' surfaces", "m", 0.0)
    reserve: NonNegative = quantity("energy that a parent keeps for itself", "energy", 0.0)
    efficiency: Annotated[float, Field(ge=1e-6, le=1)] = quantity(
        "proportion of the energy given that reaches the young", "1", 1.0
    )
    by: Literal["mother", "father", "both"] = about("which parents feed the young", "mother")


class Caring(Feature, after="reproduction"):
    """Parents feed their young, by decision or whenever possible: system `Nurse`."""

    acts = {"nurse": ("nurse",)}
    care: Care | None = about("feeding of the young; absent: none", omit=True, change=SHAPE)

    @staticmethod
    def costs(species: Any) -> Iterator[Cost]:
        if species.care is not None:
            yield Cost(("care", "rate"), species.care.rate)

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        if species.care is None and "nurse" in species.actions and "nurse" not in species.ranges():
            at = (*key, "actions", "nurse")
            yield Problem(at, "it has no care", species.actions["nurse"], "care, or remove this action group")
