"""Continuous actions of an organism."""

from ecs_eco.engine.schema import component, f32


@component
class Motor:
    """The numbers that continuous actions are carried out with in this tick, in the actions' units."""

    command: f32["continuous"] = 0.0
    # what the policy drew in each tick of the rollout of one that learns alone
    drawn: f32["horizon", "continuous"].heavy = 0.0
