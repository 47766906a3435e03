"""How far an object is on its path."""

from ecs_eco.engine.schema import component, i32


@component
class Route:
    """The place of its path that an object goes to next."""

    leg: i32.within(0, 1000) = 0
