"""Notes on a world: what is allowed, and may not be what its author means."""

from __future__ import annotations

from collections.abc import Iterator

from ecs_eco.config.models.species import Species
from ecs_eco.config.models.world import WorldConfig


def notes(config: WorldConfig) -> list[str]:
    """Return the notes on a world, a line each."""
    return [f"species.{name}: its energy can fall below 0 ({why}), and nothing happens then: give it "
            'lethal = [{ property = "energy", min = 0.0 }] or metabolism.torpor = true, or no costs'
            for name, species in config.species.items() if (why := meaningless_debt(config, species))]


def meaningless_debt(config: WorldConfig, species: Species) -> str:
    """Return why the energy of a species can fall below 0 where that means nothing: what it pays for, as
    keys; empty where energy cannot fall below 0, and where that kills or brings torpor."""
    deadly = any(limit.property == "energy" and limit.min is not None for limit in species.lethal)
    return "" if deadly or species.metabolism.torpor else ", ".join(_costs(config, species))


def _costs(config: WorldConfig, species: Species) -> Iterator[str]:
    """Keys of a species that take energy from it, whether it has any or not."""
    if species.metabolism.basal > 0:
        yield "metabolism.basal"
    if species.locomotion is not None:
        yield from (f"locomotion.cost.{gait}" for gait, cost in species.locomotion.cost.items() if cost > 0)
    for i, food in enumerate(species.diet):
        if food.gain < 0:
            yield f"diet.{i}.gain"
        prey = config.species.get(food.eats)
        if prey is not None and (prey.defence.poison > 0 or "defence.poison" in _coded(prey)):
            yield f"species.{food.eats}.defence.poison"
    yield from (trait for trait in _coded(species)
                if trait.startswith(("metabolism.basal", "locomotion.cost")))


def _coded(species: Species) -> list[str]:
    """Names of the traits that its genes code for."""
    return [gene.trait for gene in species.genome.genes if gene.trait] if species.genome is not None else []
