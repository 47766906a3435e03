"""Individual values in place of the species', coded by genes."""

from ecs_eco.engine.schema import component, f32


@component
class Traits:
    """Numbers of the species' section of the world file that are individual, in the order of
    `Species.traits`, the keys for which genes code."""

    value: f32["traits"] = 0.0  # [unit of the key]
