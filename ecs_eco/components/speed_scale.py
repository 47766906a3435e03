"""Individual speed."""

from ecs_eco.engine.schema import component, f32


@component
class SpeedScale:
    """The speed of all gaits as a multiple of the species' speeds; costs grow with its square."""

    pace: f32 = 1.0
