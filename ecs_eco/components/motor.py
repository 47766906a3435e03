"""Continuous actions of an organism."""

from ecs_eco.engine.schema import component, f32


@component
class Motor:
    """The values executed for continuous actions in this tick, in the actions' units."""

    command: f32["continuous"] = 0.0
    # the policy's draws in each tick of an individual learner's rollout
    drawn: f32["horizon", "continuous"].heavy = 0.0
