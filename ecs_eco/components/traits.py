"""Values of an organism in place of its species', where genes code for them."""

from ecs_eco.engine.schema import component, f32


@component
class Traits:
    """Numbers of the species' section of the world file that are one organism's own, in the order of
    `Species.traits`, which has those that a gene codes for."""

    value: f32["traits"] = 0.0  # [unit of the key]
