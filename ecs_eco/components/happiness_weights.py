"""Individual happiness weights."""

from ecs_eco.engine.schema import component, f32


@component
class HappinessWeights:
    """Weights of one organism's happiness network, in the order of the species' happiness weights."""

    weight: f32["desires"] = 0.0
