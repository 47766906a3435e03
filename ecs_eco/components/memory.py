"""What a nervous system keeps from one decision to the next."""

from ecs_eco.engine.schema import component, f32


@component
class Memory:
    """The state of a policy network with a memory; zero at birth."""

    state: f32["memory"].heavy = 0.0
    began: f32["memory"].heavy = 0.0  # what it was when the rollout of one that learns alone began
