"""The memory of a nervous system between decisions."""

from ecs_eco.engine.schema import component, f32


@component
class Memory:
    """The state of a policy network with a memory; zero at birth."""

    state: f32["memory"].heavy = 0.0
    began: f32["memory"].heavy = 0.0  # its value at the beginning of an individual learner's current rollout
