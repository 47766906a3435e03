"""Time passes for everyone."""

from typing import Any

import numpy as np

from ecs_eco.components import Biology
from ecs_eco.system import System


class Age(System):
    """Every organism is `dt` seconds older after a tick."""

    needs = (Biology,)
    phase = "metabolise"

    def update(self, table: Any, world: Any) -> None:
        """Let one species age."""
        age, high = table[Biology].age, table.high
        np.add(age[:high], np.float32(world.dt), out=age[:high], where=table.alive[:high])
