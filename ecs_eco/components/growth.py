"""Individual growth and spread of a plant."""

from ecs_eco.engine.schema import component, f32


@component
class Growth:
    """Growth by light, and the share of its seeds that sprout."""

    growth: f32 = 0.0  # [energy/s] in full light
    spread: f32 = 1.0
