"""What features that name object types check alike."""

from collections.abc import Iterator, Sequence
from typing import Any

from ecs_eco.config.features.feature import Key, WorldSections
from ecs_eco.config.rules import at_most
from ecs_eco.engine.errors import Problem, unknown


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
