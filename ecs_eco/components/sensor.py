"""The readings and individual properties of an organism's sensors."""

from ecs_eco.engine.schema import component, f32


@component
class Sensor:
    """The sensors of one organism: the latest readings x, positions on the body and ranges, in the species'
    order.

    It is read-only and computed on access; genes write to `Senses` instead.
    """

    # in units of each sensor, in the order of `table.species.nerves.channels`; NaN until it first senses
    readings: f32["channels"] = 0.0
    radius: f32["sensors"] = 0.0  # [m] range of each sensor; 0: no range
    forward: f32["sensors"] = 0.0  # [radii of the body] position of each sensor
    left: f32["sensors"] = 0.0  # [radii of the body]
