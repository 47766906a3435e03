"""The position of an object on its path."""

from ecs_eco.engine.schema import component, i32


@component
class Route:
    """The vertex of its path toward which an object is moving."""

    leg: i32.within(0, 1000) = 0
