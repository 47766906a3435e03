"""Eggs: a species that another species lays (`reproduction.eggs`), and that hatches into it."""

from collections.abc import Iterator, Mapping
from typing import Any

from ecs_eco.components import Genome, Incubation, Policy
from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.engine.errors import Problem, unknown
from ecs_eco.inputs.section import FREE, SHAPE, NonNegative, Positive, Section, about, quantity

LEFT_TO_THE_HATCHED = ("sensors", "actions", "diet", "locomotion", "reproduction", "genome", "growth", "care")
OWN = "an egg only stores a genome, which the animal that hatches from it expresses"


class Hatching(Section, change=FREE, own=OWN):
    """The eggs of the species whose `reproduction.eggs` names this one. They stay where they were laid and
    hatch at the end of their incubation, with their remaining energy.

    If `temperature` is given, they develop in proportion to the degrees above `threshold`.
    """

    into: str = about("species that hatches from them", change=SHAPE)
    incubation: Positive = quantity("time from laying to hatching, at `temperature`", "s")
    temperature: Positive | None = quantity(
        "temperature at which incubation takes this long; default: any temperature", "K", None
    )
    threshold: NonNegative = quantity("temperature at or below which they do not develop", "K", 273.15)


class Eggs(Feature, after="care"):
    """Eggs develop, faster where it is warmer, and hatch: system `Hatch`, component `Incubation`."""

    hatch: Hatching | None = about(
        "for eggs, the species that hatches from them and when; absent: its members are not eggs",
        omit=True,
        change=SHAPE,
    )

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        if laid_by(species) is not None:
            yield from _of_layer(species, config, key)
        if species.hatch is not None:
            yield from _of_eggs(species, config, key)

    @staticmethod
    def causes(species: Any, key: Key) -> Iterator[tuple[Key, str]]:
        if species.hatch is not None:
            yield (*key, "hatch"), "hatched"

    @staticmethod
    def becomes(species: Any) -> Iterator[str]:
        if species.hatch is not None:
            yield species.hatch.into

    @staticmethod
    def times(species: Any) -> Iterator[tuple[str, float]]:
        if species.hatch is not None:
            yield "hatch.incubation", species.hatch.incubation

    @staticmethod
    def undivided(species: Any) -> Iterator[tuple[str, str]]:
        if laid_by(species) is not None or species.hatch is not None:
            yield "reproduction.eggs", "that lays eggs"

    @staticmethod
    def furnish(species: Any, table: Any, tables: Mapping[str, Any]) -> None:
        if (laid := laid_by(species)) is None:
            return
        eggs = table.species.nursery = tables[laid]
        eggs.add_component(Incubation)
        eggs.dims |= {size: n for size, n in table.dims.items() if size not in eggs.dims}
        for component in (Genome, Policy):
            if component in table:
                eggs.add_component(component)


def laid_by(species: Any) -> str | None:
    """Return the species of the eggs that a species lays; None if it lays no eggs."""
    return getattr(species.reproduction, "eggs", None)


def _of_layer(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
    name, laid, at = key[1], species.reproduction.eggs, (*key, "reproduction", "eggs")
    eggs = [n for n, s in config.species.items() if s.hatch is not None and s.hatch.into == name]
    if laid not in config.species:
        yield unknown(at, "species", laid, eggs or config.species)
    elif laid not in eggs:
        yield Problem(at, f"no {name} hatches from it", laid, f'a species with hatch = {{ into = "{name}" }}')
    elif (most := config.species[laid].metabolism.energy_max) < (given := species.reproduction.energy_given):
        allowed = f"at most {most:g}, its metabolism.energy_max"
        yield Problem(
            (*key, "reproduction", "energy_given"), f"more than an egg can store ({laid})", given, allowed
        )
    if species.born_with == "mother":
        fault = "its newborns are eggs, whose own section defines their substances"
        yield Problem((*key, "born_with"), fault, species.born_with, '"declared"')


def _of_eggs(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
    way, at = species.hatch, (*key, "hatch")
    if way.into not in config.species:
        yield unknown((*at, "into"), "species", way.into, config.species)
    elif laid_by(config.species[way.into]) != key[1]:
        allowed = f'a species with reproduction.eggs = "{key[1]}"'
        yield Problem((*at, "into"), "it does not lay these eggs", way.into, allowed)
    if way.temperature is not None and way.temperature <= way.threshold:
        allowed = f"more than {way.threshold:g} K"
        yield Problem((*at, "temperature"), "not above the threshold", way.temperature, allowed)
    for part in LEFT_TO_THE_HATCHED:
        if getattr(species, part):
            yield Problem((*key, part), "an egg has none", allowed="this key in the species that hatches")
