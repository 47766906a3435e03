"""Building: animals make objects."""

from collections.abc import Iterator

from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.config.rules import check_objects, check_used
from ecs_eco.engine.errors import Problem
from ecs_eco.inputs.section import ANEW, FREE, POPULATION, Count, NonNegative, Section, about, quantity


class Build(Section, change=FREE, own=True):
    """An object that an animal can make at its position; without the action group `build`, the animal makes
    it whenever possible."""

    object: str = about("an object type; the action has the same name", change=ANEW)
    cost: NonNegative = quantity(
        "energy burned per object, in addition to the energy that the object contains", "energy"
    )
    spacing: NonNegative = quantity("minimum distance between these objects", "m", 0.0)
    most: Count | None = quantity(
        "maximum number at any one time; all others are counted as refused; default: no limit",
        "1",
        None,
        own=POPULATION,
    )


class Building(Feature, after="carries"):
    """Animals make objects, by decision or whenever possible: system `Build`."""

    acts = {"build": None}
    builds: list[Build] = about("objects that it can build", [], omit=True)

    @staticmethod
    def problems(species: "Building", config: WorldSections, key: Key) -> Iterator[Problem]:
        yield from check_objects(config, (*key, "builds"), species.builds, "spacing")
        yield from check_used(species, key, "builds", "build")

    @staticmethod
    def acting(species: "Building") -> Iterator[tuple[str, str, list[str]]]:
        yield "build", "object in builds", [way.object for way in species.builds]

    @staticmethod
    def makes(species: "Building") -> Iterator[str]:
        yield from (way.object for way in species.builds)
