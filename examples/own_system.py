"""A custom system with a compiled kernel and a new cause of death: lightning strikes."""

import numpy as np

from ecs_eco import System, World, draw, njit
from ecs_eco.components import Position
from ecs_eco.engine.random import USER


class Strike(System):
    """With the same small probability per second, strike each organism with lightning."""

    needs = (Position,)
    phase = "interact"

    def __init__(self, chance: float) -> None:
        self.chance = chance  # [1/s]

    def start(self, world: World) -> None:
        self.cause = world.cause("struck by lightning")

    def update(self, table, world) -> None:
        strike(
            table.alive[: table.high],
            table.uid,
            world.key,
            np.float32(self.chance * world.dt),
            self.cause,
            table.cause,
        )


@njit
def strike(alive, uid, key, chance, struck, cause):
    """Mark the organisms that die in this tick. Each random draw depends on seed, tick, uid and purpose,
    never on the row.
    """
    for row in range(alive.size):
        if alive[row] and cause[row] == 0 and draw(key, uid[row], USER) < chance:
            cause[row] = struck


if __name__ == "__main__":
    world = World.from_config("predator-prey", policies="random", systems=[Strike(0.001)]).run(50)
    series = world.series()
    for name in world.tables:
        rows = series.filter([s == name for s in series["species"].to_pylist()])
        print(f"{name}: {sum(rows['died: struck by lightning'].to_pylist())} struck in {world.tick} ticks")
