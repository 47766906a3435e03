"""Turnover between systems: the code that makes deaths, births and migration take effect."""

import weakref
from typing import Any

import numpy as np
from esper import Processor

from ecs_eco.engine.living import LivingWorld
from ecs_eco.engine.table import Request, Table


class _OfWorld(Processor):
    def __init__(self, world: LivingWorld) -> None:
        self.world = weakref.proxy(world)


class Deaths(_OfWorld):
    """The end of the `die` phase, when rows of dying entities are freed."""

    label = "the deaths of the phase die"

    def process(self, *_: object) -> None:
        """Flush the deaths."""
        self.world._flush_deaths()


class Births(_OfWorld):
    """The end of the `reproduce` phase, when newborns get their rows."""

    label = "the births of the phase reproduce"

    def process(self, *_: object) -> None:
        """Flush the births."""
        self.world._flush_births()


class Touched(_OfWorld):
    """The check after a plain processor, which can move entities or write values that kernels cannot
    handle."""

    def __init__(self, world: LivingWorld, after: Processor) -> None:
        super().__init__(world)
        self.after = after

    def process(self, *_: object) -> None:
        """Check the values that were written."""
        self.world._touch()
        self.world._admit(refuse=self.world.debug is None)


class Turnover:
    """Makes deaths and births take effect in a world's tables: frees and fills rows, and calls hooks."""

    def __init__(self, world: LivingWorld) -> None:
        self.world: Any = weakref.proxy(world)

    def heard(self) -> bool:
        """Return whether any hook observes individual deaths."""
        return bool(self.world.on_death)

    def bury_dying(self) -> None:
        """Free the rows of all entities that have a cause of death, after reporting them sorted by uid."""
        for table in self.world.tables.values():
            if (rows := table.dying()).size:
                self.bury(table, rows, ordered=True)

    def bury(self, table: Table, rows: np.ndarray, ordered: bool = False) -> None:
        """Free the rows of some entities that have a cause of death, after reporting them sorted by uid
        (`ordered`: already sorted)."""
        if self.heard():
            self.tell_deaths(table, rows if ordered else rows[table.uid[rows].argsort()])
        table.vacate(rows)

    def tell_deaths(self, table: Table, rows: np.ndarray) -> None:
        """Call the hooks for deaths."""
        for listen in tuple(self.world.on_death):
            listen(table, rows)

    def bear(self) -> list[tuple[Table, np.ndarray]]:
        """Add the requested newborns, table by table, in request order; return tables and rows."""
        born = []
        for table in self.world.tables.values():
            if not table.births:
                continue
            requests, table.births = table.births, []
            for request in requests:
                parents, second, _ = request
                if parents.size:
                    rows = self.occupy(table, request)
                    for listen in tuple(self.world.on_birth):
                        second = np.zeros_like(parents) if second is None else second
                        listen(table, rows, parents, second)
                    born.append((table, rows))
        return born

    def occupy(self, table: Table, request: Request) -> np.ndarray:
        """Assign rows and uids to the newborns of one request; return the rows."""
        parents, _, values = request
        rows = table.occupy(parents.size, self.world.next_uid, self.world.tick, values)
        self.world.next_uid += parents.size
        return rows


def depart(world: LivingWorld, table: Table, rows: np.ndarray, to: np.ndarray) -> None:
    """Free the rows i64[k] of emigrants to islands `to` i64[k], sorted by uid. This does not count as a
    death."""
    for listen in tuple(world.on_departure):
        listen(table, rows, to)
    table.vacate(rows)


def arrive(
    world: LivingWorld,
    table: Table,
    uid: np.ndarray,
    born: np.ndarray,
    values: dict[tuple[type, str], np.ndarray],
    origin: np.ndarray,
) -> None:
    """Assign rows to immigrants from islands `origin` i64[k] with these uids u64[k] and columns. This does
    not count as a birth."""
    rows = table.settle(uid, born, values)
    for listen in tuple(world.on_arrival):
        listen(table, rows, origin)
