"""What the sensors of an organism read, and what of them is its own."""

from ecs_eco.engine.schema import component, f32


@component
class Sensor:
    """The sensors of one organism: readings x of the last sensing, and where on the body and how far,
    in the species' order.

    It is looked at and not written, but for what genes say, which is written in `Senses`:
    what stands here is made when somebody looks.
    """

    # as its sensors say, in the order of `table.species.nerves.channels`; NaN before it has sensed
    readings: f32["channels"] = 0.0
    radius: f32["sensors"] = 0.0  # [m] how far each sensor reaches; 0: it has no range
    forward: f32["sensors"] = 0.0  # [radii of the body] where each sensor sits
    left: f32["sensors"] = 0.0  # [radii of the body]
