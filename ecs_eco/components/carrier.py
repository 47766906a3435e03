"""Who carries an object."""

from ecs_eco.engine.schema import component, u64


@component
class Carrier:
    """The animal that has picked up an object, which is where that animal is."""

    uid: u64 = 0  # 0: nobody
