"""Handle individual entities through esper, for small worlds and exploration. Shipped systems use columns
instead.
"""

import esper

from ecs_eco import World
from ecs_eco.components import Metabolism, Position


class Manna(esper.Processor):
    """An ordinary esper processor that gives energy to organisms in the west."""

    def process(self) -> None:
        for _, (place, metabolism) in esper.get_components(Position, Metabolism):
            if place.x < 10.0:
                metabolism.energy += 0.01


if __name__ == "__main__":
    world = World((100.0, 100.0))
    world.add_table("mouse", Position, Metabolism)
    world.add_system(Manna(), phase="environment")
    for x in (5.0, 50.0):
        world.spawn("mouse", Position(x=x), Metabolism(energy=0.5))
    world.run(10)
    # in uid order, unlike esper's own iteration
    for uid, place, metabolism in world.each(Position, Metabolism):
        print(f"mouse {uid} at x = {place.x}: energy {metabolism.energy:.2f}")
    with world:  # esper's functions act on this world
        esper.delete_entity(world.entity(2))  # a death, like world.kill(2, cause="deleted")
        esper.create_entity(Position(x=70.0), Metabolism(energy=0.4))  # a spawn
        esper.process()  # a tick, like world.run(1)
        print(
            "esper lists mice with energies of "
            f"{[round(m.energy, 2) for _, m in esper.get_component(Metabolism)]}"
        )
