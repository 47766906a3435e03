"""Individual values, encoded in genes, that replace the species' values."""

from ecs_eco.engine.schema import component, f32


@component
class Traits:
    """Individual numbers from the species' section of the world file, in the order of `Species.traits`, the
    keys for which genes code."""

    value: f32["traits"] = 0.0  # [unit of the key]
