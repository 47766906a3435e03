"""Ectothermy: animals whose temperature follows the ambient temperature slow down in the cold."""

from collections.abc import Iterator
from typing import Any

from ecs_eco.components import SpeedScale
from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.engine.errors import Problem
from ecs_eco.inputs.section import FREE, SHAPE, NonNegative, Positive, Section, about, quantity


class Cold(Section, change=FREE, own=True):
    """Temperature dependence of rates. Speeds and the basal rate have their declared values at `reference`
    and change by a factor of `q10` per 10 K (van 't Hoff 1884; between 2 and 3 in most animals).

    The body's temperature is used if `properties` has one, otherwise the ambient temperature.
    """

    q10: Positive = quantity("factor by which rates change per 10 K", "1", 2.0)
    reference: Positive = quantity("temperature at which rates have their declared values", "K", 298.15)
    torpor: NonNegative = quantity("temperature at or below which it does not move", "K", 0.0)


class Ectothermy(Feature, after="heat"):
    """Animals slow down in the cold: system `SlowDown`, component `SpeedScale`."""

    ectothermy: Cold | None = about(
        "dependence of its rates on temperature; absent: none", omit=True, change=SHAPE
    )

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        genome = species.genome if species.ectothermy is not None else None
        genes = [] if genome is None else [(("genes", i), gene) for i, gene in enumerate(genome.genes)]
        derived = [] if genome is None else [(("derived", name), one) for name, one in genome.derived.items()]
        for place, gene in (*genes, *derived):
            if gene.trait == "locomotion.pace":
                at, allowed = (*key, "genome", *place, "trait"), '"ectothermy.q10", or remove ectothermy'
                yield Problem(at, "temperature sets the pace of this species", gene.trait, allowed)

    @staticmethod
    def brings(species: Any) -> Iterator[tuple[str | None, type[Any]]]:
        if species.ectothermy is not None:
            yield None, SpeedScale
