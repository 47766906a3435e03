"""Systems define behavior. A system is an esper.Processor that receives, table by table, the columns that
it needs."""

from typing import Any, ClassVar
from zlib import crc32

import numpy as np

from ecs_eco.engine import random
from ecs_eco.engine.noted import Noted
from ecs_eco.engine.phases import Scheduled
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.table import Table
from ecs_eco.engine.world import World

TURN = random.LOT + (3 << 8)  # the purpose of draws that decide which table comes first


class System(Scheduled):
    """A behavior of all entities that have the components in `needs`, carried out once per tick.

    Derive a class, set `needs` and `phase`, define `update`, and pass an instance to `World.add_system`.

    Attributes
    ----------
    needs : tuple of type
        Components that a table must have for `update` to be called with it.
    phase : str
        One of `PHASES`; default "interact".
    acts : tuple of str
        Groups of actions that it carries out beyond the built-in ones, so that species may declare them.
    asked_for : static function of a table, optional
        For systems of the schedule of world files: the system is left out if this is true of no table.
    submodel : Submodel, optional
        Its part of the world's description (`ecs-eco describe`).
    world : World
        The world that it was added to.

    Examples
    --------
    >>> from ecs_eco import System, World
    >>> from ecs_eco.components import Metabolism
    >>> class Fast(System):
    ...     needs = (Metabolism,)
    ...     phase = "metabolise"
    ...
    ...     def update(self, table, world):
    ...         table[Metabolism].energy[table.alive] -= 0.1 * world.dt
    >>> world = World(dt=0.5)
    >>> hares = world.add_table("hare", Metabolism)
    >>> fast = world.add_system(Fast())
    >>> world.spawn("hare", Metabolism(energy=1.0))
    >>> world.flush()
    >>> round(world.run(2).get(1, Metabolism).energy, 2)
    0.9
    """

    needs: tuple[type, ...] = ()
    acts: tuple[str, ...] = ()
    asked_for: ClassVar[Any] = None  # a static function of a table: bool
    submodel: ClassVar[Submodel | None] = None
    world: World
    # the tables that have what it needs, what they were derived from, and whether several of them compete
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
        """Call `update` for every table that has the needed components.

        Override it for a system that joins several tables.

        Returns
        -------
        None
        """
        world = self.world
        now = Noted.changes, self.needs, world
        if self._fitting[0] != now:
            tables = [t for t in world.tables.values() if t.has(self.needs)]
            self._fitting = now, tables, sum(map(self.competes, tables)) > 1
        for table in self._drawn() if self._fitting[2] else self._fitting[1]:
            self.update(table, world)

    def competes(self, table: Table) -> bool:
        """Return whether members of a table compete with those of other tables in this system.

        If so, the tables take turns in a drawn order, so that none has an advantage.

        Parameters
        ----------
        table : Table

        Returns
        -------
        bool
            False unless you override it.
        """
        return False

    def _drawn(self) -> list[Table]:
        """Return the tables in an order drawn for their names."""
        names = np.array([crc32(table.name.encode()) for table in self._fitting[1]], np.uint64)
        return [self._fitting[1][i] for i in random.by_lot(self.world.key, names, TURN)]

    def update(self, table: Table, world: Any) -> None:
        """Change one table's columns by one tick; define it in your class.

        Parameters
        ----------
        table : Table
            A table that has all components in `needs`.
        world : World

        Notes
        -----
        It is called for each such table in the order in which tables were added; tables that compete
        (`competes`) take turns in an order drawn in each tick.
        """
        raise NotImplementedError(f"{type(self).__name__} defines neither update(table, world) nor process()")
