"""How far an egg has developed."""

from ecs_eco.engine.schema import component, f64


@component
class Incubation:
    """The time that an egg has developed for, counted at the temperature for which its incubation is given."""

    developed: f64 = 0.0  # [s]
