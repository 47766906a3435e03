"""Individual speed."""

from ecs_eco.engine.schema import component, f32


@component
class SpeedScale:
    """Speed of all gaits as a multiple of the species'; their cost grows with its square."""

    pace: f32 = 1.0
