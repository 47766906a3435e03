"""How organisms multiply."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ecs_eco.config.base import NonNegative, Positive, Section, about, quantity


class Reproduction(Section):
    """What every way to reproduce has."""

    rate: NonNegative = quantity("births per second and parent", "1/s")
    dispersal: Positive | None = quantity('greatest distance from parent to newborn, for place = "near"', "m", None)
    spacing: NonNegative = quantity("a newborn's least distance to others of its species", "m", 0.0)


class Bearing(Reproduction):
    """What reproduction by single parents has."""

    energy_min: NonNegative = quantity("energy that a parent needs", "energy")
    energy_given: NonNegative = quantity("energy that the parent hands to the newborn", "energy")
    age_min: NonNegative = quantity("age that a parent needs", "s", 0.0)


class Simplified(Bearing):
    """Each organism has a chance of giving birth; the newborn appears at a free place (paper, study 1)."""

    kind: Literal["simplified"]
    place: Literal["anywhere", "near"] = about("where the newborn appears", "anywhere")


class Spread(Reproduction):
    """The ground is cut into sites of side `spacing`; a free one is taken with dt (seed_rain + rate × share taken)."""

    kind: Literal["spread"]
    seed_rain: NonNegative = quantity("chance of a free site to be taken without any parent", "1/s", 0.0)
    spacing: Positive = quantity("side of a site, which one organism fills", "m")
    place: Literal["anywhere", "near"] = about("which free sites: all, or those near one taken", "anywhere")


class Asexual(Bearing):
    """Each organism divides: the newborn appears beside its parent."""

    kind: Literal["asexual"]
    place: Literal["near"] = about("the newborn is beside its parent", "near")
    dispersal: Positive = quantity("greatest distance from parent to newborn", "m", 1.0)


AnyReproduction = Annotated[Simplified | Spread | Asexual, Field(discriminator="kind")]
