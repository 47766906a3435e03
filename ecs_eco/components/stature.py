"""The size that an organism grows to."""

from ecs_eco.engine.schema import component, f32


@component
class Stature:
    """The adult's body, of organisms that grow; `Body` is what they have reached."""

    radius: f32.within(0, 1e30) = 0.5  # [m]
    mass: f32.within(0, 1e30) = 1.0  # [kg]
    residue: f32 = 0.0  # [kg] the part of Body.mass that float32 cannot hold, so that slow growth adds up
