"""What objects hold, how they come back, move and are built; what animals do with them."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ecs_eco.engine.section import (
    ANEW,
    FREE,
    POPULATION,
    SHAPE,
    Count,
    NonNegative,
    Point,
    Positive,
    Real,
    Section,
    Share,
    about,
    quantity,
)

Velocity = Annotated[list[Real], Field(min_length=2, max_length=3)]
Path = Annotated[list[Point], Field(min_length=2, max_length=1000)]


class Store(Section, change=FREE):
    """Energy in objects, for those who eat them (`diet.efficiency`); remains hold what the dead body held."""

    initial: NonNegative = quantity("energy of each object but remains", "energy", 0.0)
    decay: NonNegative = quantity("share that rots away in a second; what rots vanishes at last", "1/s", 0.0)
    left: Share = quantity(
        "share of a store that rots: the object vanishes when so much would be left of it", "1", 0.01
    )


class Motion(Section, change=FREE):
    """How objects move by themselves: with a velocity, or along a path; give one of them. Water carries them
    in addition, as it carries all bodies."""

    velocity: Velocity | None = quantity(
        "along each axis; rocks, lakes, fences and walls stop it", "m/s", None
    )
    path: Path | None = quantity(
        "places that they go to one after the other, around and around, wherever "
        "they begin; nothing stops them",
        "m",
        None,
    )
    speed: Positive | None = quantity("along the path", "m/s", None)


class Carry(Section, change=FREE, own=True):
    """What an animal can pick up, one at a time, and put down; without actions `take` and `drop` it picks up
    whatever it can and keeps it."""

    object: str = about("an object type, without solid bodies", change=SHAPE)
    reach: NonNegative = quantity("distance between the surfaces of both bodies", "m", 0.0)
    cost: NonNegative = quantity("energy burnt while it carries one", "energy/s", 0.0)


class Build(Section, change=FREE, own=True):
    """What an animal can make, where it is; without a group of actions `build` it does so whenever it can."""

    object: str = about("an object type, which is also the name of the action", change=ANEW)
    cost: NonNegative = quantity(
        "energy burnt by making one; the energy that the object holds is paid in addition", "energy"
    )
    spacing: NonNegative = quantity("least distance from the next one", "m", 0.0)
    most: Count | None = quantity(
        "how many there can be at a time; absent: no limit", "1", None, own=POPULATION
    )
