"""Sensors of an individual, where they are not the species'."""

from ecs_eco.engine.schema import component, f32


@component
class Senses:
    """How far each sensor of one organism reaches and where it sits, in the order of the species' sensors."""

    radius: f32["sensors"] = 0.0  # [m]
    forward: f32["sensors"] = 0.0  # [radii of the body]
    left: f32["sensors"] = 0.0  # [radii of the body]
