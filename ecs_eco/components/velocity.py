"""The velocity of an entity."""

from ecs_eco.engine.schema import component, f32


@component
class Velocity:
    """The motion in the last tick, along the heading and upward, and its cost."""

    speed: f32 = 0.0  # [m/s] speed along the heading
    climb: f32 = 0.0  # [m/s] speed upward, in a volume
    cost: f32 = 0.0  # [energy/s] cost of locomotion, including slope
