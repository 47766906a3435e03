"""Carrying and building: animals pick up objects and put them down, and make others."""

from collections.abc import Iterator, Sequence
from typing import Any

from ecs_eco.components import Carrier, Load
from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.config.rules import at_most
from ecs_eco.engine.errors import Problem, unknown
from ecs_eco.inputs.section import (
    ANEW,
    FREE,
    POPULATION,
    SHAPE,
    Count,
    NonNegative,
    Section,
    about,
    is_empty,
    quantity,
)


class Carry(Section, change=FREE, own=True):
    """What an animal can pick up, one at a time, and put down; without actions `take` and `drop` it picks up
    whatever it can and keeps it."""

    object: str = about("an object type, without solid bodies", change=SHAPE)
    reach: NonNegative = quantity("distance between the surfaces of both bodies", "m", 0.0)
    cost: NonNegative = quantity("energy burnt while it carries one", "energy/s", 0.0)


class Carrying(Feature, after="diet"):
    """Animals pick up objects and put them down: system `Carry`, components `Load` and `Carrier`."""

    acts = {"carry": ("take", "none", "drop")}
    carries: list[Carry] = about("what it can pick up and put down", [], exclude_if=is_empty, change=SHAPE)

    @staticmethod
    def problems(species: "Carrying", config: WorldSections, key: Key) -> Iterator[Problem]:
        """Yield what is wrong with what a species carries."""
        yield from check_named(config, (*key, "carries"), species.carries, "reach")
        for i, way in enumerate(species.carries):
            if way.object in config.objects and config.objects[way.object].body.solid:
                fault = "is solid: nothing else can be where it is"
                allowed = f"objects.{way.object}.body.solid = false"
                yield Problem((*key, "carries", i, "object"), fault, way.object, allowed)
        yield from check_used(species, key, "carries", "carry")

    @staticmethod
    def feels(species: "Carrying") -> Iterator[str]:
        """Yield whether it carries something."""
        if species.carries:
            yield "load"

    @staticmethod
    def brings(species: "Carrying") -> Iterator[tuple[str | None, type[Any]]]:
        """Yield `Load` for the species, and `Carrier` for each object type that it can carry."""
        if species.carries:
            yield None, Load
        for way in species.carries:
            yield way.object, Carrier


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


class Building(Feature, after="carries"):
    """Animals make objects, by decision or whenever they can: system `Build`."""

    acts = {"build": None}
    builds: list[Build] = about("what it can make", [], exclude_if=is_empty)

    @staticmethod
    def problems(species: "Building", config: WorldSections, key: Key) -> Iterator[Problem]:
        """Yield what is wrong with what a species builds."""
        yield from check_named(config, (*key, "builds"), species.builds, "spacing")
        yield from check_used(species, key, "builds", "build")

    @staticmethod
    def acting(species: "Building") -> Iterator[tuple[str, str, list[str]]]:
        """Yield the group of what it builds."""
        yield "build", "object in builds", [way.object for way in species.builds]

    @staticmethod
    def makes(species: "Building") -> Iterator[str]:
        """Yield what it builds."""
        yield from (way.object for way in species.builds)


def check_named(config: WorldSections, key: Key, ways: Sequence[Any], distance: str) -> Iterator[Problem]:
    """Yield what is wrong with entries that name an object type each, and look for it within a distance."""
    for i, way in enumerate(ways):
        if way.object not in config.objects:
            yield unknown((*key, i, "object"), "object type", way.object, config.objects)
        elif way.object in (other.object for other in ways[:i]):
            allowed = "one entry for each object type"
            yield Problem((*key, i, "object"), "named twice", way.object, allowed)
        fault = "larger than the world allows to look"
        yield from at_most((*key, i, distance), fault, getattr(way, distance), config.space.widest)


def check_used(species: Any, key: Key, section: str, group: str) -> Iterator[Problem]:
    """Yield what is wrong with a group of actions of a species that lacks the section it acts by."""
    if group in species.actions and not getattr(species, section):
        fault, allowed = f"it {section} nothing", f'{section} = [{{ object = "stick", … }}], or no such group'
        yield Problem((*key, "actions", group), fault, species.actions[group], allowed)
