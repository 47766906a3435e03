"""How organisms multiply."""

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
    is_absent,
    quantity,
)


class Reproduction(Section, change=FREE):
    """Keys of all kinds of reproduction."""

    dispersal: Positive | None = quantity(
        'greatest distance from parent to newborn, for place = "near"', "m", None, own=True
    )
    spacing: NonNegative = quantity(
        "least distance of a newborn to others of its species", "m", 0.0, own=True
    )


class Bearing(Reproduction):
    """Keys of reproduction paid for by parents."""

    energy_min: NonNegative = quantity("least energy of a parent", "energy", own=COLUMN)
    energy_given: NonNegative = quantity("energy of each newborn, paid by its parents", "energy", own=COLUMN)
    age_min: NonNegative = quantity("least age of a parent", "s", 0.0, own=COLUMN)
    litter: Annotated[int, Field(ge=1, le=10_000)] = quantity(
        "newborn at a time, fewer if the parent cannot pay for all", "1", 1, own=COLUMN
    )
    eggs: str | None = about(
        "species with `hatch` as which the newborn begin; absent: they are born as they are",
        None,
        exclude_if=is_absent,
        change=ANEW,
    )


class Alone(Bearing):
    """Keys of reproduction by single parents."""

    rate: NonNegative = quantity("births per second and parent", "1/s", own=True)
    immigration: NonNegative = quantity(
        "immigrants in the whole world, at random places", "1/s", 0.0, own=PARENTLESS
    )


class Simplified(Alone):
    """The former name of asexual reproduction with `place = "anywhere"` (paper, study 1)."""

    kind: Annotated[Literal["simplified"], Change(ANEW)]
    place: Literal["anywhere", "near"] = about("where the newborn appears", "anywhere")


class Spread(Reproduction, own=True):
    """The ground is divided into sites of side `spacing`; a free one is taken with probability
    dt (seed_rain + rate × share taken). Light and soil do not matter, unless they are `born_with = "soil"`.
    Each species has sites of its own: plants of two species may stand on the same ground.
    """

    kind: Annotated[Literal["spread"], Change(ANEW)]
    rate: NonNegative = quantity("births per second and parent", "1/s")
    seed_rain: NonNegative = quantity(
        "rate at which a free site is taken without a parent", "1/s", 0.0, own=PARENTLESS
    )
    spacing: Positive = quantity(
        "side of a site, which one organism fills",
        "m",
        own="it is the side of a site, and sites are the ground's",
    )
    dispersal: Positive | None = quantity(
        'greatest distance from parent to newborn, for place = "near"',
        "m",
        None,
        own="a free site looks for a plant within this distance: it is the site's",
    )
    place: Literal["anywhere", "near"] = about("which free sites: all, or those near one taken", "anywhere")


class Asexual(Alone):
    """Each organism reproduces without a mate, at a rate."""

    kind: Annotated[Literal["asexual"], Change(ANEW)]
    place: Literal["near", "anywhere"] = about(
        "where the newborn appears: next to its parent, or anywhere", "near"
    )
    dispersal: Positive = quantity(
        'greatest distance from parent to newborn, for place = "near"', "m", 1.0, own=True
    )


class Sexual(Bearing):
    """Two that meet may mate: females choose among males and bear the young;
    in a species without sexes any two mate, and one bears."""

    kind: Annotated[Literal["sexual"], Change(ANEW)]
    father_share: Share = quantity(
        "share of the newborn's energy that the father pays, when mating", "1", 0.0, own=True
    )
    reach: NonNegative = quantity("distance between the surfaces of both bodies", "m", 0.0, own=True)
    chance: Share = quantity("chance of success in one second of contact", "1", 1.0, own=True)
    consent: Literal["both", "one", "none"] = about(
        "which partners must take the action mate: both, one of the two, or none; "
        "a species without this action is always willing",
        "both",
    )
    choice: Literal["nearest", "random", "richest", "oldest"] = about(
        "choice among the ready mates within reach", "nearest"
    )
    gestation: NonNegative = quantity("from mating to birth; 0: birth in the same tick", "s", 0.0, own=True)
    rest: NonNegative = quantity("least time from a birth to the mother's next mating", "s", 0.0, own=True)
    father_rest: NonNegative = quantity("least time from a mating to the father's next", "s", 0.0, own=True)
    place: Literal["near", "anywhere"] = about("where the newborn appears, relative to the mother", "near")
    dispersal: Positive | None = quantity(
        'greatest distance from mother to newborn, for place = "near"; absent: four radii of the body',
        "m",
        None,
        own=True,
    )


AnyReproduction = Annotated[Asexual | Spread | Sexual | Simplified, Field(discriminator="kind")]
