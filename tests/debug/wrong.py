"""Systems that do something wrong once, and a coat."""

from ecs_eco import System, component, f32


@component
class Wool:
    """The coat of one animal."""

    length: f32[2] = 0.01  # [m]
    weights: f32[3].heavy = 0.0


def does(work):
    """Return a system that does `work(table, world)` to deer in tick 2."""

    def process(self, *_):
        if self.world.tick == 2:
            work(self.world.table("deer"), self.world)

    return type("Wrong", (System,), {"process": process})()
