"""Systems that do something wrong once, a coat, and the uids of deer."""

from ecs_eco import System, component, f32


@component
class Wool:
    """The coat of one animal."""

    length: f32[2] = 0.01  # [m]
    weights: f32[3].heavy = 0.0


def deer(world):
    """Return the uids of the deer of a world in which none has died yet, in the order of their rows."""
    table = world.table("deer")
    return table.uid[: table.high].tolist()


def does(work):
    """Return a system that does `work(table, world)` to deer in tick 2."""

    def process(self, *_):
        if self.world.tick == 2:
            work(self.world.table("deer"), self.world)

    return type("Wrong", (System,), {"process": process})()
