"""Energy flows start from zero in each tick."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ecs_eco.components import Metabolism
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class ResetFlows(System):
    """The energy that an organism takes in, burns and gives away is counted from zero in every tick."""

    needs = (Metabolism,)
    phase = "environment"
    divisible = True
    submodel = Submodel(changes=("Metabolism.taken", "Metabolism.burnt", "Metabolism.given"))

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Zero the flows of the last tick."""
        m, high = table[Metabolism], table.high
        m.taken[:high] = 0
        m.burnt[:high] = 0
        m.given[:high] = 0
