"""Smells leave bodies, spread and fade."""

from typing import Any

import numpy as np

from ecs_eco.engine.system import System
from ecs_eco.space.world import SpatialWorld


class Diffuse(System):
    """Every body emits into the fields; the fields diffuse and decay."""

    phase = "environment"
    world: SpatialWorld

    def process(self, *_: Any) -> None:
        """Advance all fields by one tick."""
        world = self.world
        emitters = [t for t in world.tables.values() if t.species.emits]
        for table in emitters:
            world.index(table)
        world.together(*(lambda name=name: self.spread(name, emitters) for name in world.fields))

    def spread(self, name: str, emitters: list[Any]) -> None:
        """Let one field receive what is emitted into it, then spread and fade."""
        world, field = self.world, self.world.fields[name]
        for table in emitters:
            if name in table.species.emits:
                index, amount = world.index(table), np.float32(table.species.emits[name] * world.dt)
                field.emit(index.x, index.y, index.z, np.full(index.n, amount, np.float32))
        field.pass_time(world.dt)
