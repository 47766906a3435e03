"""The development of an egg."""

from ecs_eco.engine.schema import component, f64


@component
class Incubation:
    """The time for which an egg has developed, in units of time at the reference temperature of its
    incubation."""

    developed: f64 = 0.0  # [s]
