"""Decision and happiness of a nervous system."""

from ecs_eco.engine.schema import boolean, component, f32, u8


@component
class Nervous:
    """The decision in this tick, and the happiness computed from its observations."""

    decision: u8["actions"] = 0  # the multi-hot vector H(y + z)
    happiness: f32 = 0.0  # computed from the observations in this tick
    reward: f32 = 0.0  # change in happiness in this tick; a system in the `feel` phase may write it
    awake: boolean = False  # whether it has sensed before; a newborn has no previous happiness
