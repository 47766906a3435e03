"""Position and motion, and objects that are carried."""

from ecs_eco.engine.schema import component, f32, i32, u64


@component
class Position:
    """The position of an entity's center and its heading; z is 0 on a plane."""

    x: f32 = 0.0  # [m] position of the center
    y: f32 = 0.0  # [m] position of the center
    z: f32 = 0.0  # [m] height of the center
    heading: f32 = 0.0  # [rad] counterclockwise from the x axis


@component
class Velocity:
    """The motion in the last tick, along the heading and upward, and its cost."""

    speed: f32 = 0.0  # [m/s] speed along the heading
    climb: f32 = 0.0  # [m/s] speed upward, in a volume
    cost: f32 = 0.0  # [energy/s] cost of locomotion, including slope


@component
class SpeedScale:
    """The speed of all gaits as a multiple of the species' speeds; costs grow with its square."""

    pace: f32 = 1.0


@component
class Route:
    """The vertex of its path toward which an object is moving."""

    leg: i32.within(0, 1000) = 0


@component
class Carrier:
    """The animal that carries an object; the object moves with it."""

    uid: u64 = 0  # uid; 0: none


@component
class Load:
    """The object that an animal has picked up."""

    object: u64 = 0  # uid; 0: none
    mass: f32 = 0.0  # [kg]
