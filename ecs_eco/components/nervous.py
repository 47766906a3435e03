"""Decision and happiness of a nervous system."""

from ecs_eco.engine.schema import boolean, component, f32, u8


@component
class Nervous:
    """The decision of this tick and the happiness for its observations."""

    decision: u8["actions"] = 0  # the multi-hot vector H(y + z)
    happiness: f32 = 0.0  # for the observations of this tick
    reward: f32 = 0.0  # change of happiness in this tick; a system in the phase `feel` may write it
    awake: boolean = False  # whether it has sensed before; a newborn has no previous happiness
