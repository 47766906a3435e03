"""Systems define behavior. A system is an esper.Processor that receives the columns it needs, table by
table."""

from typing import Any, ClassVar

from ecs_eco.engine.noted import Noted
from ecs_eco.engine.phases import Scheduled
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.table import Table
from ecs_eco.engine.world import World


class System(Scheduled):
    """A behavior of all entities that have the components in `needs`; it runs once per tick.

    Subclass it, set `needs` and `phase`, implement `update`, and pass an instance to
    `World.add_system`.

    Attributes
    ----------
    needs : tuple of type
        Components that a table must have for `update` to be called with it.
    phase : str
        One of `PHASES`; default: "interact".
    acts : tuple of str
        Action groups, in addition to the built-in ones, that the system implements and that species can
        declare.
    asked_for : static function of a table, optional
        For systems in the schedule of world files: the system is omitted unless this is true for at least one
        table.
    submodel : Submodel, optional
        The system's part of the world's description (`ecs-eco describe`).
    world : World
        The world to which the system was added.

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
    asked_for: ClassVar[Any] = None  # static function: table → bool
    submodel: ClassVar[Submodel | None] = None
    world: World
    # the state from which the tables were derived, and the tables that have all `needs`
    _fitting: tuple[tuple[Any, ...], list[Table]] = ((), [])

    def __init_subclass__(cls) -> None:
        """Raise TypeError if `update` is defined but `needs` is not: it would be called for every table."""
        super().__init_subclass__()
        declared = any("needs" in vars(c) for c in cls.__mro__[: cls.__mro__.index(System)])
        if cls.update is not System.update and cls.process is System.process and not declared:
            raise TypeError(
                f"{cls.__name__} has no `needs`: declare the components of the tables that it updates, "
                "as in needs = (Position, Metabolism); needs = () for all tables"
            )

    def process(self, *_: object) -> None:
        """Call `update` for every table that has the needed components.

        Override this in a system that combines several tables. If their members compete, collect the requests
        of all tables, then serve the individuals in random order, as `ecs_eco.systems.Build` does.

        Returns
        -------
        None

        Examples
        --------
        >>> from ecs_eco import System, World
        >>> class Census(System):
        ...     def process(self, *_):
        ...         self.n = sum(table.n for table in self.world.tables.values())
        >>> world = World.from_config("predator-prey", seed=1)
        >>> census = world.add_system(Census())
        >>> world.run(1).systems[-1].n > 700
        True
        """
        world = self.world
        now = Noted.changes, self.needs, world
        if self._fitting[0] != now:
            self._fitting = now, [t for t in world.tables.values() if t.has(self.needs)]
        for table in self._fitting[1]:
            self.update(table, world)

    def update(self, table: Table, world: Any) -> None:
        """Advance one table's columns by one tick; implement this in your class.

        Parameters
        ----------
        table : Table
            A table that has all components in `needs`.
        world : World

        Notes
        -----
        This method is called for each such table in the order in which tables were added.
        """
        raise NotImplementedError(f"{type(self).__name__} defines neither update(table, world) nor process()")
