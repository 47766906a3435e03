"""Costs of the nervous system: energy for hidden units, receptors and learning."""

import math
from collections.abc import Iterator
from typing import Any

from ecs_eco.components import NeuralCost
from ecs_eco.config.features.feature import Cost, Feature, Key, WorldSections
from ecs_eco.engine.errors import Problem
from ecs_eco.inputs.section import FREE, SHAPE, NonNegative, Section, about, quantity


class NeuralRates(
    Section,
    change=FREE,
    own="genes code for hidden units, sensors and learning rates, which determine what an animal pays",
):
    """Energy that the nervous system burns in addition to `metabolism.basal`, independent of body mass. An
    animal whose genes code for its hidden units, sensors or learning rate pays for its own values.
    """

    hidden_unit: NonNegative = quantity(
        "energy burned per hidden unit of the policy network", "energy/s", 0.0
    )
    receptor: NonNegative = quantity("energy burned per channel of its sensors", "energy/s", 0.0)
    transition: NonNegative = quantity(
        "energy burned per transition (one decision and its reward) that it records to learn from; an "
        "individual learning rate multiplies it by its ratio to ppo.learning_rate",
        "energy",
        0.0,
    )


class NeuralCosts(Feature, after="metabolism"):
    """Nervous systems cost energy: system `MaintainNerves`, component `NeuralCost`."""

    neural_costs: NeuralRates | None = about(
        "costs of hidden units, receptors and learning; absent: none", omit=True, change=SHAPE
    )

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        way = species.neural_costs
        if way is None:
            return
        plain = species.policy.thinks and species.policy.network is None
        lacks = {
            "hidden_unit": None if plain else "it has no built-in policy network",
            "transition": None if species.policy.thinks else "it has no policy network",
            "receptor": None if species.sensors else "it has no sensors",
        }
        for name, fault in lacks.items():
            if fault is not None and getattr(way, name) > 0:
                yield Problem((*key, "neural_costs", name), fault, getattr(way, name), "0")

    @staticmethod
    def costs(species: Any) -> Iterator[Cost]:
        if (way := species.neural_costs) is not None:
            units = float(sum(species.policy.hidden))
            yield Cost(("neural_costs", "hidden_unit"), way.hidden_unit, units, owed=True)
            yield Cost(("neural_costs", "receptor"), way.receptor, owed=True)
            yield Cost(("neural_costs", "transition"), way.transition, math.inf, owed=True)

    @staticmethod
    def brings(species: Any) -> Iterator[tuple[str | None, type[Any]]]:
        if species.neural_costs is not None:
            yield None, NeuralCost
