"""The shape of a body other than a sphere."""

from ecs_eco.engine.schema import component, f32


@component
class Shape:
    """A box with rounded edges, in units of Body.radius, so that a growing body keeps its shape. A sphere has
    only a rounding, a capsule has a length and a rounding, and a box has no rounding. Length is along the
    heading, width across it, and height vertical."""

    half_length: f32.within(0, 1e6) = 0.0  # [radii of the body] of the inner box, without its rounding
    half_width: f32.within(0, 1e6) = 0.0  # [radii of the body]
    half_height: f32.within(0, 1e6) = 0.0  # [radii of the body]
    rounding: f32.within(0, 1) = 1.0  # [radii of the body] by which the inner box is enlarged on all sides
