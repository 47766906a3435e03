"""The carrier of an object."""

from ecs_eco.engine.schema import component, u64


@component
class Carrier:
    """The animal that has picked up an object and whose position the object shares."""

    uid: u64 = 0  # uid; 0: none
