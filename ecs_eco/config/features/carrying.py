"""Carrying: animals pick up objects and put them down."""

from collections.abc import Iterator
from typing import Any

from ecs_eco.components import Carrier, Load
from ecs_eco.config.features.feature import Cost, Feature, Key, WorldSections
from ecs_eco.config.rules import check_objects, check_used
from ecs_eco.engine.errors import Problem
from ecs_eco.inputs.section import FREE, SHAPE, NonNegative, Section, about, quantity


class Carry(Section, change=FREE, own=True):
    """An object type that an animal can pick up, one at a time, and put down; without the actions `take` and
    `drop`, it picks up any object that it can carry, and keeps it."""

    object: str = about("an object type whose bodies are not solid", change=SHAPE)
    reach: NonNegative = quantity("maximum distance between the bodies' surfaces", "m", 0.0)
    cost: NonNegative = quantity("energy burned while it carries an object", "energy/s", 0.0)


class Carrying(Feature, after="diet"):
    """Animals pick up objects and put them down: system `Carry`, components `Load` and `Carrier`."""

    acts = {"carry": ("take", "none", "drop")}
    carries: list[Carry] = about("objects that it can pick up and put down", [], omit=True, change=SHAPE)

    @staticmethod
    def problems(species: "Carrying", config: WorldSections, key: Key) -> Iterator[Problem]:
        yield from check_objects(config, (*key, "carries"), species.carries, "reach")
        for i, way in enumerate(species.carries):
            if way.object in config.objects and config.objects[way.object].body.solid:
                fault = "is solid, so no other body can be in the same place"
                allowed = f"objects.{way.object}.body.solid = false"
                yield Problem((*key, "carries", i, "object"), fault, way.object, allowed)
        yield from check_used(species, key, "carries", "carry")

    @staticmethod
    def feels(species: "Carrying") -> Iterator[tuple[str, str]]:
        if species.carries:
            yield "load", "Load.mass"

    @staticmethod
    def costs(species: Any) -> Iterator[Cost]:
        for i, way in enumerate(species.carries):
            yield Cost(("carries", i, "cost"), way.cost, owed=True)

    @staticmethod
    def meets(species: Any) -> Iterator[tuple[str, str, float]]:
        for i, way in enumerate(species.carries):
            yield f"carries.{i}", way.object, way.reach

    @staticmethod
    def brings(species: "Carrying") -> Iterator[tuple[str | None, type[Any]]]:
        if species.carries:
            yield None, Load
        for way in species.carries:
            yield way.object, Carrier
