"""Hares and a fox, for tests of esper's functions; and a plain component as esper knows them."""

from ecs_eco import component, f32
from ecs_eco.components import Body, Position


@component
class Coat:
    """A component that only some have."""

    colour: f32 = 0.5


class Tag:
    """A plain object, as esper knows components."""

    def __init__(self, text="") -> None:
        self.text = text


def populated(world):
    """A world with hares 1 to 3 and the fox 4."""
    world.add_table("hare", Position, Body)
    world.add_table("fox", Position, Body, Coat)
    for x in (1, 2, 3):
        world.spawn("hare", Position(x=x), Body(mass=x))
    world.spawn("fox", Position(x=9))
    world.flush()
    return world
