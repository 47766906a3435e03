"""Individual events of a recording: their columns, their text as numbers for checkpoints, and migrants."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Metabolism, Parentage

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

_EACH = ("tick", "species", "uid", "x", "y", "z", "energy")
MIGRATION = {
    "arrivals": (*_EACH, "origin", "born", "parent", "parent2", "genome"),
    "departures": (*_EACH, "target"),
}
"""Events on islands: immigrants with origin, birth and parents; emigrants with target."""

EVENTS = {
    "births": (*_EACH, "parent", "parent2", "genome"),
    "deaths": (*_EACH, "cause", "killer", "age"),
    "snapshots": (*_EACH, "heading", "happiness"),
} | MIGRATION


def as_numbers(column: np.ndarray) -> np.ndarray:
    """Return a text column as character codes u32[n, letters], and any other column unchanged."""
    if column.dtype.kind not in "SU":
        return column
    wide = np.ascontiguousarray(column.astype(f"U{max(1, int(np.char.str_len(column).max(initial=1)))}"))
    return wide.view(np.uint32).reshape(len(column), -1)


def as_text(numbers: np.ndarray) -> np.ndarray:
    """Return the text that character codes represent."""
    text = np.ascontiguousarray(numbers).view(f"U{numbers.shape[1]}")[:, 0]
    return text.astype("S") if numbers.size and numbers.max() < 128 else text


class Migrations:
    """Records migrants in a recorder's pages and events, in the tick before they move."""

    def __init__(self, recorder: Any, world: SpatialWorld) -> None:
        self.recorder, self.world = recorder, world
        self.words = dict.fromkeys(("origin", "target"), world.config.archipelago.names)
        world.on_departure.append(self.left)
        world.on_arrival.append(self.came)

    def left(self, table: Table, rows: np.ndarray, to: np.ndarray) -> None:
        """Record emigrants to islands `to` i64[k] before their rows i64[k] are freed."""
        if self.recorder.details is not None:
            self.recorder.details.died(table, rows, self.world)
        self._note("departures", "emigrants", "exported", table, rows, to)

    def came(self, table: Table, rows: np.ndarray, origin: np.ndarray) -> None:
        """Record immigrants in rows i64[k] from islands `origin` i64[k]."""
        if self.recorder.details is not None:
            self.recorder.details.born(table, rows)
        none = np.zeros(rows.size, np.uint64)
        both = ("mother", "father") if Parentage in table else ()
        parents = [getattr(table[Parentage], parent)[rows] for parent in both] or [none, none]
        genomes = self.recorder._genomes(table, rows) if self.recorder.keeps else none
        more = origin, table.born[rows], *parents, genomes
        self._note("arrivals", "immigrants", "imported", table, rows, *more)

    def _note(
        self, kind: str, count: str, flow: str, table: Table, rows: np.ndarray, island: np.ndarray, *more: Any
    ) -> None:
        r = self.recorder
        s = r.place.get(table.name)
        if s is None:
            return
        r._counts[count][r._at, s] += rows.size
        if Metabolism in table:
            r._ledger[flow][r._at, s] += table[Metabolism].energy[rows].sum(dtype=np.float64)
        if r.keeps:
            more = island.astype(np.int8), *more, *r.fields.of(table, rows)
            r._events[kind].append((*r._where(table, s, rows), *more))
