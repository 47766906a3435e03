"""Smells leave bodies, spread and fade."""

from typing import Any

import numpy as np

from ecs_eco.system import System


class Diffuse(System):
    """Every body puts what its species emits into the fields; the fields diffuse and decay."""

    phase = "environment"

    def process(self, *_: Any) -> None:
        """Advance all fields by one tick."""
        world = self.world
        for table in world.tables.values():
            for name, rate in table.traits.get("emits", {}).items():
                index = world.index(table)
                world.fields[name].emit(index.x, index.y, index.z, np.full(index.n, rate * world.dt, np.float32))
        for field in world.fields.values():
            field.pass_time(world.dt)
