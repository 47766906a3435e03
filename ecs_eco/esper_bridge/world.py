"""A World that esper can inspect: `with world:` shows its organisms as esper's entities."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from typing import Any, Self

import esper
import numpy as np

from ecs_eco.engine import world as engine
from ecs_eco.engine.table import Request, Table
from ecs_eco.engine.turnover import Turnover
from ecs_eco.esper_bridge import turns
from ecs_eco.esper_bridge.context import Context, switch_back

_worlds: weakref.WeakSet[World] = weakref.WeakSet()
_entering = threading.Lock()


class World(engine.World):
    """Entities in tables, and the systems that act on them.

    `dt` [s] is the length of a tick; `seed` fixes every random draw; `threads` affects speed, never results.
    Worlds stay separate: each has its own esper context, which `with world:` enters.

    For hooks, see `ecs_eco.engine.world.World`.
    """

    def __init__(self, *, dt: float = 1.0, seed: int = 0, threads: int = 1, name: str = "world") -> None:
        super().__init__(dt=dt, seed=seed, threads=threads, name=name)
        # whether other threads may use esper between its ticks
        self.apart = threading.current_thread() is not threading.main_thread()
        self._free = False  # whether ticks of this run need no turn
        self._enter()
        self.context = Context(self)
        self.turnover: Turnover = Told(self)
        self._outer: list[str] = []
        weakref.finalize(self, _forget, self.context, self._outer, threading.get_ident())

    def _enter(self) -> None:
        """Register this world; worlds of other threads, and this one if there are any, learn of each other."""
        me = threading.current_thread()
        with _entering:
            others = [w for w in _worlds if w.owner is not me and w.owner.is_alive()]
            _worlds.add(self)
        for world in (self, *others) if others else ():
            world.apart = True

    def add_table(
        self, name: str, *components: type[Any], capacity: int = 64, dims: Mapping[str, int] | None = None
    ) -> Table:
        """Declare a kind of entity with these components; `dims` gives sizes for the names in their shapes."""
        table = super().add_table(name, *components, capacity=capacity, dims=dims)
        self.context.registry.join(table)
        return table

    def run(self, ticks: int, progress: Callable[[int, int], Any] | None = None) -> Self:
        """Advance the world by a number of ticks.

        Parameters
        ----------
        ticks : int
            At least 0.
        progress : callable, optional
            Called as `progress(done, ticks)` about ten times a second.

        Returns
        -------
        World
            This world. The run ends early, after a whole tick, on Ctrl-C or if `stop` was called.

        Raises
        ------
        UnfinishedTick
            If an error or a second Ctrl-C interrupted an earlier tick; such a world can only be inspected.

        Examples
        --------
        >>> from ecs_eco import World
        >>> World.from_config("predator-prey", seed=1).run(10).tick
        10
        """
        self._mine()
        self.context.require()
        self._free = self.apart and not self._needs_turns()
        if self._free:
            return super().run(ticks, progress)
        with turns.turn:
            outside = esper.current_world
        try:
            return super().run(ticks, progress)
        finally:
            with turns.turn:
                switch_back(outside)

    def _pass_tick(self) -> None:
        """Run all processors, with this world as esper's current one if they may use esper."""
        if self._free:
            super()._pass_tick()
            return
        with turns.turn:
            outside = esper.current_world if self.apart else None  # another thread may change `apart`
            self.context.show()
            super()._pass_tick()
            if outside is not None:
                esper.switch_world(outside)
        if turns.turn.waiting:
            turns.turn.leave()

    def _needs_turns(self) -> bool:
        """Return whether a tick may use esper or another library whose state all threads share."""
        return True

    def _entered(self) -> AbstractContextManager[None]:
        """Return a context in which esper shows this world."""
        return self.context.inside()

    def sync(self) -> None:
        """Update esper's entities: one for each living organism, with a handle per component.

        esper's functions do this automatically after births and deaths, so you need not call it.

        Examples
        --------
        >>> import esper
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Position
        >>> world = World()
        >>> hares = world.add_table("hare", Position)
        >>> world.spawn("hare", n=2)
        >>> world.flush()
        >>> world.sync()
        >>> with world:
        ...     len(list(esper.get_component(Position)))
        2
        """
        self.context.registry.sync(self.tables.values())

    def entity(self, uid: int) -> int:
        """Return esper's number for a living entity.

        Parameters
        ----------
        uid : int

        Returns
        -------
        int
            The number is valid only in this process and is never saved.

        Raises
        ------
        KeyError
            If no living entity has this uid.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Position
        >>> world = World()
        >>> hares = world.add_table("hare", Position)
        >>> world.spawn("hare")
        >>> world.flush()
        >>> world.uid(world.entity(1))
        1
        """
        return self.context.registry.number(*self.locate(uid))

    def uid(self, entity: int) -> int:
        """Return the uid of the organism behind one of esper's entities.

        Parameters
        ----------
        entity : int
            esper's number.

        Returns
        -------
        int
            0 if the organism has not been born yet.

        Raises
        ------
        KeyError
            If esper has no such entity.

        Examples
        --------
        >>> import esper
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Position
        >>> world = World()
        >>> snails = world.add_table("snail", Position)
        >>> with world:
        ...     snail = esper.create_entity(Position(x=5.0))
        >>> uid = world.run(1).uid(snail)
        >>> world.get(uid, Position).x
        5.0
        """
        return int(self.context.registry.entities[entity].uid)

    def __enter__(self) -> Self:
        self._mine()
        turns.turn.__enter__()
        self._outer.append(esper.current_world)
        try:
            self.context.show()
            self.context.registry.stale = True  # columns may have been changed by hand
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        try:
            switch_back(self._outer.pop())
        finally:
            turns.turn.__exit__()


class Told(Turnover):
    """Reports births and deaths to esper's handlers for the "birth" and "death" events."""

    def heard(self) -> bool:
        """Return whether deaths are reported one by one."""
        return bool(self.world.on_death) or "death" in self.world.context.registry.events

    def tell_deaths(self, table: Table, rows: np.ndarray) -> None:
        """Call the hooks for deaths, then esper's handlers."""
        super().tell_deaths(table, rows)
        world = self.world
        if "death" in world.context.registry.events:
            causes = [world.causes[cause - 1] for cause in table.cause[rows]]
            world.context.tell("death", self._numbers(table, rows), causes)

    def bear(self) -> list[tuple[Table, np.ndarray]]:
        """Add newborns, then call esper's handlers."""
        born = super().bear()
        if "birth" in self.world.context.registry.events:
            numbers = [number for table, rows in born for number in self._numbers(table, rows)]
            self.world.context.tell("birth", numbers)
        return born

    def occupy(self, table: Table, request: Request) -> np.ndarray:
        """Assign rows and uids to the newborns of one request; an entity that is waiting for the birth keeps
        the values and components that it has received."""
        registry = self.world.context.registry
        given = registry.newborn(request) if registry.waiting else None
        if given is None:
            return super().occupy(table, request)
        parents, second, _ = request
        rows = super().occupy(table, (parents, second, self.world._values(table, given)))
        registry.bear(request, table, int(rows[0]))
        return rows

    def _numbers(self, table: Table, rows: np.ndarray) -> list[int]:
        return [self.world.context.registry.number(table, row) for row in rows.tolist()]


def _forget(context: Context, within: list[str], thread: int) -> None:
    context.end()
    turns.turn.give_back(len(within), thread)  # the world was freed within its `with` block
