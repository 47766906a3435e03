"""The energy budget of one organism."""

from ecs_eco.engine.schema import component, f32, i32


@component
class Metabolism:
    """The stored energy, and the flows in the last tick, which the ledger adds up.

    Each world has its own unit of energy.
    """

    energy: f32 = 1.0  # [energy] energy held
    digesting: i32 = 0  # [ticks] time until it can eat again
    taken: f32 = 0.0  # [energy] taken in during this tick
    burnt: f32 = 0.0  # [energy] burned during this tick
    given: f32 = 0.0  # [energy] passed to offspring during this tick
