"""The physical state of bodies, and their exchange of heat."""

from ecs_eco.engine.schema import component, f32


@component
class Physical:
    """Physical state of an organism or object, in SI units."""

    temperature: f32 = 293.15  # [K]
    pressure: f32 = 101325.0  # [Pa]
    electric_current: f32 = 0.0  # [A]
    luminous_intensity: f32 = 0.0  # [cd]


@component
class Coat:
    """Fur, feathers or fat."""

    insulation: f32.within(0, 1e30) = 0.0  # [K m^2/W]


@component
class HeatExchange:
    """The part of the temperature that float32 cannot represent, kept so that slow warming adds up."""

    residue: f32 = 0.0  # [K] to be added to Physical.temperature
