"""How fast an organism is, where that is its own and not its species'."""

from ecs_eco.engine.schema import component, f32


@component
class Vigour:
    """Speed of all gaits as a multiple of the species'; what they cost goes with its square."""

    pace: f32 = 1.0
