"""A plant's defense against being eaten."""

from ecs_eco.engine.schema import component, f32


@component
class Defence:
    """Toughness and poison of one organism as food."""

    toughness: f32 = 0.0  # fraction of bites that fail
    poison: f32 = 0.0  # [energy] lost by the eater
