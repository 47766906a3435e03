"""The carrier of an object."""

from ecs_eco.engine.schema import component, u64


@component
class Carrier:
    """The animal that carries an object; the object moves with it."""

    uid: u64 = 0  # uid; 0: none
