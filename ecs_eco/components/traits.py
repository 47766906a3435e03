"""Individual values, encoded in genes, that replace the species' values."""

from ecs_eco.engine.schema import component, f32


@component
class Traits:
    """Individual values of the world-file keys that genes code for, in the order of `Species.traits`."""

    value: f32["traits"] = 0.0  # [unit of the key]
