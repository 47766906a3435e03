"""The conformation of an entity and its mass."""

from ecs_eco.engine.schema import component, f32


@component
class Body:
    """A sphere, or a disc on a plane (the paper's conformation), and its mass."""

    radius: f32.within(0, 1e30) = 0.5  # [m]
    mass: f32.within(0, 1e30) = 1.0  # [kg]
