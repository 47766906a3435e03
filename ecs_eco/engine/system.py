"""Systems define behavior. A system is an esper.Processor that receives, table by table, the columns that
it needs."""

from typing import Any, ClassVar
from zlib import crc32

import numpy as np

from ecs_eco.engine import random
from ecs_eco.engine.noted import Noted
from ecs_eco.engine.phases import Scheduled
from ecs_eco.engine.table import Table
from ecs_eco.engine.world import World

TURN = random.LOT + (3 << 8)  # the purpose of draws that decide which table comes first


class System(Scheduled):
    """A process that changes all entities with the components in `needs`, once per tick.

    A subclass declares `needs` (components) and `phase`, and defines `update(table, world)`, which is called
    for every table that has them all, in the order in which tables were added; if several of them compete, in
    an order drawn in each tick. A system that joins tables overrides `process`. `acts` lists the groups of
    actions that it carries out, beyond the built-in ones, for species to use. A world from a file includes a
    shipped system with `asked_for` only if that is true of a table, so that other worlds run as fast as
    without it.
    """

    needs: tuple[type, ...] = ()
    acts: tuple[str, ...] = ()
    asked_for: ClassVar[Any] = None  # a static function of a table: bool
    world: World
    # the tables that have what it needs, what they were derived from, and whether several of them compete
    _fitting: tuple[tuple[Any, ...], list[Table], bool] = ((), [], False)

    def process(self, *_: object) -> None:
        """Update every table that has the needed components."""
        world = self.world
        now = Noted.changes, self.needs, world
        if self._fitting[0] != now:
            tables = [t for t in world.tables.values() if t.has(self.needs)]
            self._fitting = now, tables, sum(map(self.competes, tables)) > 1
        for table in self._drawn() if self._fitting[2] else self._fitting[1]:
            self.update(table, world)

    def competes(self, table: Table) -> bool:
        """Return whether a table competes with others of its kind, so that it should not always come
        first."""
        return False

    def _drawn(self) -> list[Table]:
        """Return the tables in an order drawn for their names."""
        names = np.array([crc32(table.name.encode()) for table in self._fitting[1]], np.uint64)
        return [self._fitting[1][i] for i in random.by_lot(self.world.key, names, TURN)]

    def update(self, table: Table, world: Any) -> None:
        """Change one table's columns by one tick."""
        raise NotImplementedError(f"{type(self).__name__} defines neither update(table, world) nor process()")
