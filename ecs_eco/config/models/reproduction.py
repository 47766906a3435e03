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
    """Keys of all kinds of reproduction."""

    dispersal: Positive | None = quantity(
        'maximum distance from parent to newborn, for place = "near"', "m", None, own=True
    )
    spacing: NonNegative = quantity(
        "minimum distance from a newborn to members of its species", "m", 0.0, own=True
    )


class Bearing(Reproduction):
    """Keys of reproduction that costs parents energy."""

    energy_min: NonNegative = quantity("minimum energy of a parent", "energy", own=COLUMN)
    energy_given: NonNegative = quantity("energy of each newborn, paid by its parents", "energy", own=COLUMN)
    age_min: NonNegative = quantity("minimum age of a parent", "s", 0.0, own=COLUMN)
    litter: Annotated[int, Field(ge=1, le=10_000)] = quantity(
        "litter size, smaller if the parent cannot pay for all", "1", 1, own=COLUMN
    )
    eggs: str | None = about(
        "species with `hatch` that newborns start as; absent: newborns belong to their own species",
        omit=True,
        change=ANEW,
    )


class Alone(Bearing):
    """Keys of reproduction by single parents."""

    rate: NonNegative = quantity("births per second and parent", "1/s", own=True)
    immigration: NonNegative = quantity(
        "immigrants per second in the whole world, at random positions", "1/s", 0.0, own=PARENTLESS
    )


class Simplified(Alone):
    """The former name of asexual reproduction with `place = "anywhere"` (paper, study 1)."""

    kind: Annotated[Literal["simplified"], Change(ANEW)]
    place: Literal["anywhere", "near"] = about("position of the newborn", "anywhere")


class Spread(Reproduction, own=True):
    """The ground is divided into sites of side `spacing`; a free site is taken with probability dt
    (seed_rain + rate × proportion of sites taken). Light and soil have no effect unless they are
    `born_with = "soil"`. Each species has its own sites: plants of two species may stand on the same
    ground."""

    kind: Annotated[Literal["spread"], Change(ANEW)]
    rate: NonNegative = quantity("births per second and parent", "1/s")
    seed_rain: NonNegative = quantity(
        "rate at which a free site is taken without a parent", "1/s", 0.0, own=PARENTLESS
    )
    spacing: Positive = quantity(
        "side of a site, which a single organism occupies",
        "m",
        own="the side of a site is a property of the ground",
    )
    dispersal: Positive | None = quantity(
        'maximum distance from parent to newborn, for place = "near"',
        "m",
        None,
        own="the search distance is a property of the site",
    )
    place: Literal["anywhere", "near"] = about(
        "available free sites: all, or only sites near an occupied site", "anywhere"
    )


class Asexual(Alone):
    """Each organism reproduces without a mate, at a rate."""

    kind: Annotated[Literal["asexual"], Change(ANEW)]
    place: Literal["near", "anywhere"] = about(
        "position of the newborn: next to its parent, or anywhere", "near"
    )
    dispersal: Positive = quantity(
        'maximum distance from parent to newborn, for place = "near"', "m", 1.0, own=True
    )


class Sexual(Bearing):
    """Two organisms in contact may mate: females choose among males and bear the young; in a species
    without sexes any two may mate, and either bears."""

    kind: Annotated[Literal["sexual"], Change(ANEW)]
    father_share: Share = quantity(
        "proportion of the newborn's energy that the father pays when mating", "1", 0.0, own=True
    )
    reach: NonNegative = quantity("maximum distance between the surfaces of both bodies", "m", 0.0, own=True)
    chance: Share = quantity("probability of success per second of contact", "1", 1.0, own=True)
    consent: Literal["both", "one", "none"] = about(
        "number of partners that must take the action mate: both, one or none; a species without this "
        "action is always willing",
        "both",
    )
    choice: Literal["nearest", "random", "richest", "oldest"] = about(
        "choice among the ready mates within reach", "nearest"
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
        'maximum distance from mother to newborn, for place = "near"; absent: four radii of the body',
        "m",
        None,
        own=True,
    )


AnyReproduction = Annotated[Asexual | Spread | Sexual | Simplified, Field(discriminator="kind")]
