"""Constant population sizes, for pre-training."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Biology, Metabolism, Nervous, Position
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.life import sizes
from ecs_eco.life.founders import scatter

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Respawn(System):
    """Every animal that dies is replaced at once by an adult with a founder's genome, at a random position."""

    needs = (Position, Metabolism, Biology, Nervous)
    phase = "reproduce"
    divisible = True
    submodel = Submodel("Replacement of the dead", draws="the places of replacements")

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Restore one species to its initial number."""
        k = table.species.count - world.bands.count(table)
        if k <= 0:
            return
        identity = np.arange(world.next_uid, world.next_uid + k, dtype=np.uint64)
        values = scatter(table, world, identity)
        if (heredity := table.species.heredity) is not None:
            values |= heredity.founders(world, table, identity)
        table.request(np.zeros(k, np.uint64), values | sizes.of_adults(table, values, k))
