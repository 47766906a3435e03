"""The carrier of an object."""

from ecs_eco.engine.schema import component, u64


@component
class Carrier:
    """The animal that has picked up an object, which moves along with the animal."""

    uid: u64 = 0  # uid; 0: none
