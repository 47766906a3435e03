"""Systems are behaviour: an esper.Processor that gets, table by table, the columns it named."""

from typing import Any, ClassVar
from zlib import crc32

import numpy as np

from ecs_eco.engine import random
from ecs_eco.engine.noted import Noted
from ecs_eco.engine.phases import Scheduled
from ecs_eco.engine.table import Table
from ecs_eco.engine.world import World

TURN = random.LOT + (3 << 8)  # purpose of the draws of which table comes first


class System(Scheduled):
    """What happens to all entities that have the components in `needs`, once a tick.

    A subclass declares `needs` (components) and `phase`, and defines `update(table, world)`, called for every
    table that has them all, in the order in which tables were added; where several of them compete, in an
    order drawn in each tick. A system that joins tables overrides `process`. `acts` are the groups of actions
    that it carries out, beyond those that every world knows: species may use them. A world from a file has a
    shipped system with `asked_for` only where that is true of a table: others are as fast as without.
    """

    needs: tuple[type, ...] = ()
    acts: tuple[str, ...] = ()
    asked_for: ClassVar[Any] = None  # a static function of a table: bool
    world: World
    # the tables that have what it needs, what that was found from, and whether several of them compete
    _fitting: tuple[tuple[Any, ...], list[Table], bool] = ((), [], False)

    def __init_subclass__(cls) -> None:
        """Raise TypeError where `update` is defined and `needs` is not: it would be called for every table."""
        super().__init_subclass__()
        declared = any("needs" in vars(c) for c in cls.__mro__[: cls.__mro__.index(System)])
        if cls.update is not System.update and cls.process is System.process and not declared:
            raise TypeError(
                f"{cls.__name__} has no `needs`: declare the components of the tables that it updates, "
                "as in needs = (Position, Metabolism); needs = () for all tables"
            )

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
        """Return whether a table takes what others of its kind may want, too: none should always be first."""
        return False

    def _drawn(self) -> list[Table]:
        """Return the tables in an order drawn for their names."""
        names = np.array([crc32(table.name.encode()) for table in self._fitting[1]], np.uint64)
        return [self._fitting[1][i] for i in random.by_lot(self.world.key, names, TURN)]

    def update(self, table: Table, world: Any) -> None:
        """Change one table's columns by one tick."""
        raise NotImplementedError(f"{type(self).__name__} defines neither update(table, world) nor process()")
