"""The policy network of an individual learner."""

from ecs_eco.engine.schema import component, f32, i32


@component
class Policy:
    """Weights of one organism's policy and value networks in one vector, and the state of their optimizer."""

    weights: f32["weights"].heavy = 0.0
    moment_1: f32["weights"].heavy = 0.0  # Adam's running mean of gradients
    moment_2: f32["weights"].heavy = 0.0  # Adam's running mean of squared gradients
    steps: i32 = 0  # optimizer steps since birth
    updates: i32 = 0  # updates since birth, one per rollout
