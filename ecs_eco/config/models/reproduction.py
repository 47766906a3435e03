"""Reproduction of organisms."""

from typing import Annotated, Literal

from pydantic import Field

from ecs_eco.inputs.section import (
    ANEW,
    COLUMN,
    FREE,
    PARENTLESS,
    Change,
    NonNegative,
    Positive,
    Section,
    Share,
    about,
    quantity,
)


class Reproduction(Section, change=FREE):
    """Keys shared by all kinds of reproduction."""

    dispersal: Positive | None = quantity(
        'maximum distance from parent to newborn, for place = "near"', "m", None, own=True
    )
    spacing: NonNegative = quantity(
        "minimum distance from a newborn to members of its species", "m", 0.0, own=True
    )


class Bearing(Reproduction):
    """Keys shared by kinds of reproduction that cost parents energy."""

    energy_min: NonNegative = quantity("minimum energy of a parent", "energy", own=COLUMN)
    energy_given: NonNegative = quantity("energy of each newborn, paid by its parents", "energy", own=COLUMN)
    age_min: NonNegative = quantity("minimum age of a parent", "s", 0.0, own=COLUMN)
    litter: Annotated[int, Field(ge=1, le=10_000)] = quantity(
        "litter size, reduced if the parent lacks the energy for the whole litter", "1", 1, own=COLUMN
    )
    eggs: str | None = about(
        "species of the eggs that it lays, with the `hatch` key; default: it lays no eggs, and newborns "
        "belong to its own species",
        omit=True,
        change=ANEW,
    )


class Alone(Bearing):
    """Keys shared by kinds of reproduction with a single parent."""

    rate: NonNegative = quantity("births per parent per second", "1/s", own=True)
    immigration: NonNegative = quantity(
        "immigrants per second in the whole world, at random positions", "1/s", 0.0, own=PARENTLESS
    )


class Simplified(Alone):
    """The former name of asexual reproduction with `place = "anywhere"` (paper, study 1)."""

    kind: Annotated[Literal["simplified"], Change(ANEW)]
    place: Literal["anywhere", "near"] = about("position of the newborn", "anywhere")


class Spread(Reproduction, own=True):
    """The ground is divided into square sites with side `spacing`; a free site is colonized at the rate
    seed_rain + rate × proportion of occupied sites [1/s]. Light has no effect, and soil
    only with `born_with = "soil"`. Each species has its own sites, so plants of two species can occupy the same
    ground."""

    kind: Annotated[Literal["spread"], Change(ANEW)]
    rate: NonNegative = quantity("births per parent per second while all other sites are free", "1/s")
    seed_rain: NonNegative = quantity(
        "rate at which a free site is colonized without a parent", "1/s", 0.0, own=PARENTLESS
    )
    spacing: Positive = quantity(
        "side of a site, which holds one organism", "m", own="the side of a site is a property of the ground"
    )
    dispersal: Positive | None = quantity(
        'maximum distance from parent to newborn, for place = "near"',
        "m",
        None,
        own="the search distance is a property of the site",
    )
    place: Literal["anywhere", "near"] = about(
        "free sites that can be colonized: all, or only those near an occupied site", "anywhere"
    )


class Asexual(Alone):
    """Each organism reproduces without a mate, at a given rate."""

    kind: Annotated[Literal["asexual"], Change(ANEW)]
    place: Literal["near", "anywhere"] = about(
        "position of the newborn: next to its parent, or anywhere", "near"
    )
    dispersal: Positive = quantity(
        'maximum distance from parent to newborn, for place = "near"', "m", 1.0, own=True
    )


class Sexual(Bearing):
    """Two organisms in contact can mate: females choose among males and bear the young; in a species without
    sexes, any two can mate and either can bear the young."""

    kind: Annotated[Literal["sexual"], Change(ANEW)]
    father_share: Share = quantity(
        "proportion of the newborn's energy that the father pays when mating", "1", 0.0, own=True
    )
    reach: NonNegative = quantity(
        "maximum distance between the surfaces of the two bodies", "m", 0.0, own=True
    )
    chance: Share = quantity("probability of success per second of contact", "1", 1.0, own=True)
    consent: Literal["both", "one", "none"] = about(
        "how many partners must take the `mate` action; a species without it is always willing", "both"
    )
    choice: Literal["nearest", "random", "richest", "oldest"] = about(
        "which of the ready mates within reach is chosen", "nearest"
    )
    gestation: NonNegative = quantity(
        "time from mating to birth; 0: birth in the same tick", "s", 0.0, own=True
    )
    rest: NonNegative = quantity("minimum time from a birth to the mother's next mating", "s", 0.0, own=True)
    father_rest: NonNegative = quantity(
        "minimum time from a mating to the father's next mating", "s", 0.0, own=True
    )
    place: Literal["near", "anywhere"] = about("position of the newborn relative to the mother", "near")
    dispersal: Positive | None = quantity(
        'maximum distance from mother to newborn, for place = "near"; default: four body radii',
        "m",
        None,
        own=True,
    )


AnyBearing = Asexual | Sexual | Simplified
AnyReproduction = Annotated[Asexual | Spread | Sexual | Simplified, Field(discriminator="kind")]
