"""The record of an island's migrants: their numbers, the energy that they carry, and each arrival and
departure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Metabolism, Parentage
from ecs_eco.record.ledger import COUNTS_ROW, LEDGER_ROW, MIGRATION

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

ISLAND_COUNTS_ROW = np.dtype([*COUNTS_ROW.descr, ("immigrants", np.int32), ("emigrants", np.int32)])
ISLAND_LEDGER_ROW = np.dtype([*LEDGER_ROW.descr, *((name, np.float64) for name in MIGRATION)])


class Migrations:
    """Records migrants in the pages and events of a recorder, in the tick before they move."""

    def __init__(self, recorder: Any, world: SpatialWorld) -> None:
        self.recorder, self.world = recorder, world
        self.words = dict.fromkeys(("origin", "target"), world.config.archipelago.names)
        world.on_departure.append(self.left)
        world.on_arrival.append(self.came)

    def left(self, table: Table, rows: np.ndarray, to: np.ndarray) -> None:
        """Record emigrants to islands `to` i64[k], before their rows i64[k] are freed."""
        if self.recorder.details is not None:
            self.recorder.details.died(table, rows, self.world)
        self._note("departures", "emigrants", "exported", table, rows, to)

    def came(self, table: Table, rows: np.ndarray, origin: np.ndarray) -> None:
        """Record immigrants from islands `origin` i64[k]: rows i64[k]."""
        if self.recorder.details is not None:
            self.recorder.details.born(table, rows)
        none = np.zeros(rows.size, np.uint64)
        parents = (
            (table[Parentage].mother[rows], table[Parentage].father[rows])
            if Parentage in table
            else (none, none)
        )
        genomes = self.recorder._genomes(table, rows) if self.recorder.keeps else none
        self._note(
            "arrivals", "immigrants", "imported", table, rows, origin, table.born[rows], *parents, genomes
        )

    def _note(
        self, kind: str, count: str, flow: str, table: Table, rows: np.ndarray, island: np.ndarray, *more: Any
    ) -> None:
        r = self.recorder
        s = r.place.get(table.name)
        if s is None:
            return
        r._counts[count][r._at, s] += rows.size
        energy = table[Metabolism].energy[rows] if Metabolism in table else None
        if energy is not None:
            r._ledger[flow][r._at, s] += energy.sum(dtype=np.float64)
        if r.keeps:
            more = island.astype(np.int8), *more, *r.fields.of(table, rows)
            r._events[kind].append((*r._where(table, s, rows), *more))
