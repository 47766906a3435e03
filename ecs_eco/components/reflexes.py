"""Individual reflexes."""

from ecs_eco.engine.schema import component, f32, i8


@component
class Reflexes:
    """Connection weights and thresholds of one organism's reflex network, in the order of the species'
    connections."""

    weight: i8["connections"] = 0  # -1 blocks the action, 0 leaves it to the policy, 1 forces it
    threshold: f32["connections"] = 0.0  # reading above which the connection is active
