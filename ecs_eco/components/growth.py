"""Individual growth and spread of a plant."""

from ecs_eco.engine.schema import component, f32


@component
class Growth:
    """Growth in the light, and the proportion of seeds that germinate."""

    growth: f32 = 0.0  # [energy/s] in full light
    spread: f32 = 1.0
