"""Individual sensors."""

from ecs_eco.engine.schema import component, f32


@component
class Senses:
    """The range and position of each sensor of one organism, in the order of the species' sensors."""

    radius: f32["sensors"] = 0.0  # [m]
    forward: f32["sensors"] = 0.0  # [radii of the body]
    left: f32["sensors"] = 0.0  # [radii of the body]
