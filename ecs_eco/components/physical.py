"""The physical properties in Definition 1 other than position, shape and mass."""

from ecs_eco.engine.schema import component, f32


@component
class Physical:
    """Physical state of an organism or object, in SI units."""

    temperature: f32 = 293.15  # [K]
    pressure: f32 = 101325.0  # [Pa]
    electric_current: f32 = 0.0  # [A]
    luminous_intensity: f32 = 0.0  # [cd]
