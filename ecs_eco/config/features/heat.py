"""Heat: a body's temperature changes through regulation and through exchange with its surroundings."""

from collections.abc import Iterator
from typing import Any

from ecs_eco.config.features.feature import Cost, Feature, Key, WorldSections
from ecs_eco.engine.errors import Problem
from ecs_eco.inputs.section import FREE, SHAPE, Column, NonNegative, Positive, Section, about, quantity


class Heat(Section, change=FREE):
    """Heat exchange with the surroundings by Newton's law of cooling, over the surface of the body's shape.

    The body needs an initial value, `properties.temperature`.
    """

    specific_heat: Positive = quantity("specific heat capacity of the body", "J/(kg K)", 3500.0)
    conductance: NonNegative = quantity(
        "heat transfer coefficient of the bare surface; about 10 in still air and 100 in water",
        "W/(m^2 K)",
        10.0,
    )
    insulation: NonNegative = quantity(
        "thermal resistance of fur, feathers or fat, in series with the bare surface",
        "K m^2/W",
        0.0,
        own=Column("Coat"),
    )


class Regulation(Section, own=True):
    """Regulation of body temperature: at full power up to the set point, then as much as needed.

    It costs the animal energy, and stops when none is left.
    """

    set_point: NonNegative = quantity("set point", "K")
    warming: NonNegative = quantity("maximum additional heat production, such as shivering", "W", 0.0)
    cooling: NonNegative = quantity("maximum additional heat loss, such as panting", "W", 0.0)
    cost: NonNegative = quantity("energy burned per joule of warming or cooling", "energy/J")


class BodyHeat(Heat, own=True):
    """Heat exchange with the surroundings by Newton's law of cooling, metabolic heat, and regulation.

    The species needs a value at birth, `properties.temperature`.
    """

    metabolic_heat: NonNegative = quantity(
        "heat released per unit of energy burned, except energy burned for regulation", "J/energy", 0.0
    )
    regulate: Regulation | None = about("regulation of its temperature; absent: none", None)


class Warmth(Feature, after="properties"):
    """Bodies exchange heat: system `ExchangeHeat`, components `HeatExchange` and, for a gene, `Coat`."""

    heat: BodyHeat | None = about(
        "heat exchange; absent: its temperature never changes", omit=True, change=SHAPE
    )

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        yield from check_heat(species, key)
        regulation = None if species.heat is None else species.heat.regulate
        if regulation is not None and regulation.warming == regulation.cooling == 0:
            allowed = "a power [W] for warming, cooling or both; or remove regulate"
            yield Problem(
                (*key, "heat", "regulate", "warming"), "warming and cooling are both 0", 0.0, allowed
            )

    @staticmethod
    def costs(species: Any) -> Iterator[Cost]:
        way = None if species.heat is None else species.heat.regulate
        if way is not None:
            yield Cost(("heat", "regulate", "cost"), way.cost, max(way.warming, way.cooling))


class WarmObjects(Feature, after="properties"):
    """Objects exchange heat: system `ExchangeHeat`, component `HeatExchange`."""

    heat: Heat | None = about(
        "heat exchange; absent: their temperature never changes", omit=True, change=SHAPE
    )

    @staticmethod
    def problems(kind: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        yield from check_heat(kind, key)


def check_heat(kind: Any, key: Key) -> Iterator[Problem]:
    """Yield problems with the temperature of a species or object type whose bodies exchange heat."""
    if kind.heat is None:
        return
    at, known = (*key, "properties", "temperature"), kind.properties.get("temperature")
    if known is None:
        allowed = "the initial temperature [K], or remove heat"
        yield Problem(at, "is missing, but heat changes it", allowed=allowed)
    elif known < 0:
        yield Problem(at, "below absolute zero", known, "at least 0 K")
