"""The conformation of an entity and its mass."""

from ecs_eco.engine.schema import component, f32


@component
class Body:
    """The size of a body (the paper's conformation) and its mass. Bodies are spheres, or discs on a plane,
    unless the component Shape defines another shape.

    A capsule's radius is measured across it; a box has the radius of its smallest enclosing sphere.
    """

    radius: f32.within(0, 1e30) = 0.5  # [m] radius of the body
    mass: f32.within(0, 1e30) = 1.0  # [kg] mass of the body
