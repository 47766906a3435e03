"""Individual insulation."""

from ecs_eco.engine.schema import component, f32


@component
class Coat:
    """Fur, feathers or fat."""

    insulation: f32.within(0, 1e30) = 0.0  # [K m^2/W]
