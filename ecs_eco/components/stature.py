"""The adult size of an organism."""

from ecs_eco.engine.schema import component, f32


@component
class Stature:
    """The adult body of an organism that grows; `Body` describes its current body."""

    radius: f32.within(0, 1e30) = 0.5  # [m]
    mass: f32.within(0, 1e30) = 1.0  # [kg]
    # [kg] part of Body.mass that float32 cannot represent, kept so that slow growth adds up
    residue: f32 = 0.0
