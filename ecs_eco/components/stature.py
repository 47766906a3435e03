"""The size to which an organism grows."""

from ecs_eco.engine.schema import component, f32


@component
class Stature:
    """The adult body of organisms that grow; `Body` is the current one."""

    radius: f32.within(0, 1e30) = 0.5  # [m]
    mass: f32.within(0, 1e30) = 1.0  # [kg]
    residue: f32 = 0.0  # [kg] part of Body.mass beyond float32, kept so that slow growth adds up
