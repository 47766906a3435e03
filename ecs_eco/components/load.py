"""The object that an animal carries."""

from ecs_eco.engine.schema import component, f32, u64


@component
class Load:
    """The object that an animal has picked up."""

    object: u64 = 0  # uid; 0: none
    mass: f32 = 0.0  # [kg]
