"""The energy of organisms: stores and flows, growth in the light, and defence against being eaten."""

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


@component
class Growth:
    """Growth in the light, and the proportion of seeds that germinate."""

    growth: f32 = 0.0  # [energy/s] in full light
    spread: f32 = 1.0


@component
class Defence:
    """Toughness and poison of one organism as food."""

    toughness: f32 = 0.0  # fraction of bites that fail
    poison: f32 = 0.0  # [energy] lost by the eater
