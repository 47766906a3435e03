"""The state of a body's heat exchange beyond its temperature."""

from ecs_eco.engine.schema import component, f32


@component
class HeatExchange:
    """The part of the temperature that float32 cannot represent, kept so that slow warming adds up."""

    residue: f32 = 0.0  # [K] to be added to Physical.temperature
