"""The shape of a body that is no sphere."""

from ecs_eco.engine.schema import component, f32


@component
class Shape:
    """A box whose edges are rounded, in units of Body.radius, so that a body that grows keeps its shape:
    nothing but rounding is a sphere, length and rounding a capsule, no rounding a box.

    Length lies along the heading, width across it, height upright.
    """

    half_length: f32.within(0, 1e6) = 0.0  # [radii of the body] of the box within, before it is rounded
    half_width: f32.within(0, 1e6) = 0.0  # [radii of the body]
    half_height: f32.within(0, 1e6) = 0.0  # [radii of the body]
    rounding: f32.within(0, 1) = 1.0  # [radii of the body] by which that box is enlarged on all sides
