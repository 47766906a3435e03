"""The energy ledger of objects, which recordings do not include."""

from __future__ import annotations

import numpy as np

from ecs_eco.components import Metabolism
from ecs_eco.engine.table import Table
from ecs_eco.record.ledger import LEDGER, imbalance
from ecs_eco.space.world import SpatialWorld


class Stores:
    """Keeps a ledger, summed over ticks, for each object type with energy."""

    def __init__(self, world: SpatialWorld) -> None:
        self.world = world
        self.ledger = {
            name: dict.fromkeys(LEDGER, 0.0)
            for name, table in world.tables.items()
            if table.species.is_object and Metabolism in table
        }
        for name, page in self.ledger.items():
            page["stock_before"] = page["stock_after"] = self._held(world.tables[name])
        world.on_birth.append(self._born)
        world.on_death.append(self._died)

    def note(self) -> None:
        """Add the flows of the completed tick; raise AssertionError if a ledger does not close."""
        for name, page in self.ledger.items():
            table = self.world.tables[name]
            page["burnt"] += float(table[Metabolism].burnt[table.rows()].sum(dtype=np.float64))
            page["stock_after"] = self._held(table)
            if abs(imbalance(page)) > 1e-6 * sum(map(abs, page.values())) + 1e-9:
                where = f"{self.world.name}, tick {self.world.tick}"
                raise AssertionError(
                    f"{where}: the energy ledger of {name} is off by {imbalance(page):g}: {page}"
                )

    def _born(self, table: Table, rows: np.ndarray, parents: np.ndarray, second: np.ndarray) -> None:
        if table.name in self.ledger:
            energy = table[Metabolism].energy[rows]
            self.ledger[table.name]["endowed"] += float(energy.sum(dtype=np.float64))

    def _died(self, table: Table, rows: np.ndarray) -> None:
        if table.name in self.ledger:
            m, page = table[Metabolism], self.ledger[table.name]
            page["lost"] += float(m.energy[rows].sum(dtype=np.float64))
            if self.world.ticking:
                page["burnt"] += float(m.burnt[rows].sum(dtype=np.float64))

    @staticmethod
    def _held(table: Table) -> float:
        return float(table[Metabolism].energy[table.rows()].sum(dtype=np.float64))
