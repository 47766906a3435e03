"""Emissions: bodies put smells into fields, or what they are made of."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.config.features.substances import substances_of
from ecs_eco.engine.errors import Problem, unknown
from ecs_eco.engine.section import FREE, SHAPE, Name, NonNegative, Section, about, quantity, table


class Emission(Section, own=True):
    """A smell of what the body is made of: rate × amount of a substance in the body [mol] each second."""

    substance: str = about("what smells")
    rate: NonNegative = quantity("share of the substance in the body, in a second", "1/s")
    consume: bool = about("whether the body loses what it emits", False, change=SHAPE)


class Emitting(Feature, after=("defence", "decomposition")):
    """Organisms and objects emit into fields: system `Diffuse`."""

    emits: dict[Name, NonNegative | Emission] = table(
        "field = amount put into it [1/s], or { substance, rate, consume }", dict, change=FREE, own=True
    )

    @staticmethod
    def problems(species: Emitting, config: WorldSections, key: Key) -> Iterator[Problem]:
        """Yield emissions into no field, of no substance, and from nothing."""
        for name, way in species.emits.items():
            at, holds = (*key, "emits", name), getattr(config.fields.get(name), "substance", None)
            if name not in config.fields:
                yield unknown(at, "field", name, config.fields)
            if isinstance(way, Emission) and way.substance not in config.substances:
                yield unknown((*at, "substance"), "substance", way.substance, config.substances)
            elif isinstance(way, Emission) and not substances_of(config, key[1]):
                fault, allowed = "its bodies hold no substances", "substances, or a number"
                yield Problem((*at, "substance"), fault, way.substance, allowed)
            elif holds and not (isinstance(way, Emission) and way.consume and way.substance == holds):
                fault = f"the field holds {holds}, which cannot come from nothing"
                allowed = f'{{ substance = "{holds}", rate = …, consume = true }}, or `exchange`'
                yield Problem(at, fault, allowed=allowed)

    @staticmethod
    def undivided(species: Any) -> Iterator[tuple[str, str]]:
        """Yield that bodies cannot whose emissions follow from what they hold."""
        if any(isinstance(way, Emission) for way in species.emits.values()):
            yield "emits", "that emits what its bodies are made of"
