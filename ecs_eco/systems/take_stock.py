"""The ledger of matter starts a new tick."""

from __future__ import annotations

from ecs_eco.components import Matter
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.life.matter import NUMBER, stocks
from ecs_eco.space.world import SpatialWorld


class TakeStock(System):
    """The ledger of matter records amounts set from outside since the last tick."""

    phase = "environment"
    submodel = Submodel()
    asked_for = staticmethod(lambda table: Matter in table)
    world: SpatialWorld

    def process(self, *_: object) -> None:
        """Compare the content of bodies and fields with the ledger."""
        books = self.world.matter
        if books is not None:
            books.flows[:, :, NUMBER["set"]] += stocks(self.world, books) - books.stock - books.flows.sum(2)
