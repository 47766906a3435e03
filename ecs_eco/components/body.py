"""The bodies of organisms and objects: size, shape and adult size."""

from ecs_eco.engine.schema import component, f32


@component
class Body:
    """The size of a body (the paper's conformation) and its mass. Bodies are spheres, or discs on a plane,
    unless the component Shape defines another shape.

    A capsule's radius is measured across it; a box has the radius of its smallest enclosing sphere.
    """

    radius: f32.within(0, 1e30) = 0.5  # [m] radius of the body
    mass: f32.within(0, 1e30) = 1.0  # [kg] mass of the body


@component
class Shape:
    """A box with rounded edges, in units of Body.radius, so that a growing body keeps its shape. A sphere has
    only a rounding, a capsule has a length and a rounding, and a box has no rounding. Length is along the
    heading, width across it, and height vertical."""

    half_length: f32.within(0, 1e6) = 0.0  # [radii of the body] of the inner box, without its rounding
    half_width: f32.within(0, 1e6) = 0.0  # [radii of the body]
    half_height: f32.within(0, 1e6) = 0.0  # [radii of the body]
    rounding: f32.within(0, 1) = 1.0  # [radii of the body] by which the inner box is enlarged on all sides


@component
class Stature:
    """The adult body of an organism that grows; `Body` describes its current body."""

    radius: f32.within(0, 1e30) = 0.5  # [m]
    mass: f32.within(0, 1e30) = 1.0  # [kg]
    # [kg] part of Body.mass that float32 cannot represent, kept so that slow growth adds up
    residue: f32 = 0.0
