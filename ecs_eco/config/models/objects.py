"""What objects hold, and how they move."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ecs_eco.engine.section import FREE, NonNegative, Point, Positive, Real, Section, Share, quantity

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
