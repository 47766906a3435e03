"""The development of an egg."""

from ecs_eco.engine.schema import component, f64


@component
class Incubation:
    """The development of an egg, as the equivalent time at its reference temperature."""

    developed: f64 = 0.0  # [s]
