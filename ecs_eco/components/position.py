"""The position and heading of an entity."""

from ecs_eco.engine.schema import component, f32


@component
class Position:
    """The position of an entity's center and its heading; z is 0 on a plane."""

    x: f32 = 0.0  # [m] position of the center
    y: f32 = 0.0  # [m] position of the center
    z: f32 = 0.0  # [m] height of the center
    heading: f32 = 0.0  # [rad] counterclockwise from the x axis
