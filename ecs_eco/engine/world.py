"""A World: tables of organisms, a clock, and systems in phases. It does not deal with space, biology or
esper."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from typing import Any, Self

import numpy as np
from esper import Processor

from ecs_eco.compiled.workers import Workers
from ecs_eco.engine import random
from ecs_eco.engine.arguments import called_with, positive, seed_number, whole_number
from ecs_eco.engine.codes import Codes
from ecs_eco.engine.errors import UnknownName, unknown_name
from ecs_eco.engine.interruption import require_whole, whole
from ecs_eco.engine.living import Underway
from ecs_eco.engine.noted import Noted
from ecs_eco.engine.phases import LAST, PHASES, Schedule, Scheduled, priority_of
from ecs_eco.engine.running import live
from ecs_eco.engine.schema import C
from ecs_eco.engine.table import Table
from ecs_eco.engine.turnover import Births, Deaths, Touched, Turnover


class World:
    """Entities in tables, and the systems that act on them.

    `dt` [s] is the length of a tick; `seed` fixes every random draw; `threads` affects speed, never results.

    Hooks are lists of functions. `before_tick` (no arguments) is called before each tick of `run`, `on_death`
    (table, rows) before the rows are freed, `on_birth` (table, rows, uids of the first and second parents, 0
    for none) once the rows are filled, and `on_departure` (table, rows, numbers of the destination islands)
    and `on_arrival` (table, rows, numbers of the origin islands) for migrants. Hooks are called in the list's
    order at the time of the event, so a hook can remove itself. Hooks are not saved.
    """

    def __init__(self, *, dt: float = 1.0, seed: int = 0, threads: int = 1, name: str = "world") -> None:
        self.name, self.dt, self.seed = name, positive("dt", dt, "seconds"), seed_number(seed)
        self.threads = whole_number("threads", threads, 1)
        self.tick = 0
        self.tables: dict[str, Table] = Noted()
        self.systems: list[Scheduled] = []
        self.causes: list[str] = ["culled"]
        self.codes: dict[str, int] = Codes(self.causes)
        self.next_uid = 1
        self.before_tick: list[Callable[[], Any]] = []
        self.on_death: list[Callable[[Table, np.ndarray], Any]] = []
        self.on_birth: list[Callable[[Table, np.ndarray, np.ndarray, np.ndarray], Any]] = []
        self.on_departure: list[Callable[[Table, np.ndarray, np.ndarray], Any]] = []
        self.on_arrival: list[Callable[[Table, np.ndarray, np.ndarray], Any]] = []
        self.ticking = False  # whether a tick is in progress
        self.stopping = False  # whether `run` should return as soon as possible
        self.stopped = False  # whether the last `run` returned early
        # an action that is in progress or was stopped before it was complete
        self.underway: Underway | None = None
        self.debug: Any = None  # the checks of debug mode
        self.owner = threading.current_thread()  # the only thread that may use the world
        self.workers = Workers(self.threads)
        # kernel, n, *arguments, work=None: runs `kernel(first, last, *arguments)` over 0…n, on all threads if
        # the number of items, `work`, is worth it
        self.split: Callable[..., None] = self.workers.split
        # runs independent pieces of work, on all threads if that is faster; they must not share arrays to
        # write to
        self.together: Callable[..., None] = partial(self.workers.together, self.tables.values())
        self.schedule = Schedule()
        self.turnover = Turnover(self)  # how births and deaths take effect
        self._places = 0  # the positions that systems occupy in phases
        self.schedule.put(Deaths(self), priority_of("die", LAST))
        self.schedule.put(Births(self), priority_of("reproduce", LAST))
        weakref.finalize(self, self.workers.end)

    def __repr__(self) -> str:
        return (
            f"<World {self.name!r} at tick {self.tick}: "
            f"{', '.join(f'{t.n} {n}' for n, t in self.tables.items())}>"
        )

    @property
    def time(self) -> float:
        """Return the simulated time since the start [s]."""
        return self.tick * self.dt

    @property
    def key(self) -> np.uint64:
        """Key for this tick's random numbers, to pass to `draw` and `draw_many`."""
        return random.tick_key(self.seed, self.tick)

    # --- contents --------------------------------------------------------------------------------------------

    def add_table(
        self, name: str, *components: type[Any], capacity: int = 64, dims: Mapping[str, int] | None = None
    ) -> Table:
        """Add a table for entities with these components; `dims` maps names in their shapes to sizes."""
        if name in self.tables:
            raise ValueError(f"table {name!r} already exists; choose another name")
        table = self.tables[name] = Table(
            name, components, capacity=capacity, dims=dims, place=len(self.tables)
        )
        return table

    def add_system(self, system: Processor, phase: str | None = None, priority: int | None = None) -> Any:
        """Add a system at the end of its phase, and return it.

        Parameters
        ----------
        system : System or esper.Processor
            An instance, which can belong to only one world.
        phase : str, optional
            One of `PHASES`; default: the system's phase, or "interact" for a plain esper.Processor.
        priority : int, optional
            Position among all processors, instead of a phase, as in esper: priorities count down from 0, with
            one million per phase.

        Returns
        -------
        System or esper.Processor
            The same instance.

        Raises
        ------
        TypeError
            If `system` is not an instance of a system or processor.
        ValueError
            If the phase is unknown or the system is already in a world.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Body, Position, Velocity
        >>> from ecs_eco.systems import Move
        >>> world = World((10.0, 10.0))
        >>> snails = world.add_table("snail", Position, Velocity, Body)
        >>> move = world.add_system(Move())
        >>> move.phase
        'move'
        """
        phase = phase or getattr(system, "phase", "interact")
        if not isinstance(system, Processor):
            raise TypeError(
                f"system {system!r} is not an ecs_eco.System or esper.Processor; pass an instance, as in Move()"
            )
        if phase not in PHASES:
            raise ValueError(unknown_name(f"system {type(system).__name__}", "phase", phase, PHASES))
        if getattr(system, "world", None) is not None:
            raise ValueError(
                f"system {type(system).__name__} is already in a world; create another instance for this one"
            )
        system.phase = phase  # type: ignore[attr-defined]
        # esper keeps the system alive, which must not keep the world alive
        system.world = weakref.proxy(self)  # type: ignore[attr-defined]
        self.systems.append(system)  # type: ignore[arg-type]
        self._places += 1
        place = priority_of(phase, self._places) if priority is None else priority
        self.schedule.put(system, place)
        if isinstance(system, Scheduled):
            system.start(self)
        else:  # it can move entities through esper
            self.schedule.put(Touched(self, system), place)
        return system

    def remove_processor(self, processor: Processor) -> None:
        """Remove a plain esper.Processor from the schedule.

        Parameters
        ----------
        processor : esper.Processor
            An instance that `add_system` added.

        Raises
        ------
        RuntimeError
            If the processor is a `System`, because the schedule depends on it.

        Examples
        --------
        >>> import esper
        >>> from ecs_eco import World
        >>> class Count(esper.Processor):
        ...     def process(self, *_):
        ...         print("tick")
        >>> world = World()
        >>> count = world.add_system(Count())
        >>> world.remove_processor(count)
        >>> world.systems
        []
        """
        if isinstance(processor, Scheduled) or processor not in self.systems:
            raise RuntimeError(
                f"world {self.name!r}: {type(processor).__name__} is part of the schedule and cannot be removed; "
                "build a world without it, or replace it with your own system"
            )
        for one in [p for p in self.schedule if p is processor or getattr(p, "after", None) is processor]:
            self.schedule.remove(one)
        self.systems.remove(processor)

    def table(self, name: str) -> Table:
        """Return the table of a species or object type.

        Parameters
        ----------
        name : str

        Returns
        -------
        Table

        Raises
        ------
        UnknownName
            If the name is unknown; this KeyError suggests the most similar name.

        Examples
        --------
        >>> from ecs_eco import World
        >>> World.from_config("predator-prey").table("wolf").n
        250
        """
        try:
            return self.tables[name]
        except KeyError:
            raise UnknownName(unknown_name("world", "table", name, self.tables)) from None

    def cause(self, name: str) -> int:
        """Return the code of a cause of death, registering the cause if it is new.

        Parameters
        ----------
        name : str
            Cause of death, such as "starved".

        Returns
        -------
        int
            Code for `table.cause`, at least 1.

        Examples
        --------
        >>> from ecs_eco import World
        >>> World().cause("struck by lightning")
        2
        """
        return self.codes[name]

    def spawn(self, name: str, *components: object, n: int = 1, parent: int = 0) -> None:
        """Request newborns, which are added at the end of the `reproduce` phase, or at `flush`.

        Parameters
        ----------
        name : str
            Name of the table.
        *components : object
            Components with the newborns' values; other fields have the table's defaults. On a torus,
            positions beyond the edge wrap around.
        n : int, default 1
            Number of newborns.
        parent : int, default 0
            uid of the parent; 0 for none.

        Raises
        ------
        UnknownName
            If a table or component is unknown.
        ValueError
            If a position is outside a world with walls, or if a value is beyond the limits of its field.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Metabolism, Position
        >>> world = World((10.0, 10.0))
        >>> hares = world.add_table("hare", Position, Metabolism)
        >>> world.spawn("hare", Position(x=5.0, y=5.0), Metabolism(energy=0.5), n=3)
        >>> world.flush()
        >>> hares.n
        3
        """
        table = self.table(name)
        n = whole_number(f"spawn {name!r}: n", n, 1)
        values = self._values(table, components, n)
        if not 0 <= parent < 2**64:
            raise ValueError(f"spawn {name!r}: parent is {parent}; it must be a uid, or 0 for none")
        table.request(np.full(n, parent, np.uint64), values)

    def _values(
        self, table: Table, components: Iterable[Any], n: int = 1
    ) -> dict[tuple[type, str], np.ndarray]:
        """Return the checked values of `n` newborns with these components."""
        values = {}
        for handle in components:
            if type(handle) not in table:
                table[type(handle)]  # raises the error that lists the fields
            if type(handle) in table.derived:
                raise TypeError(
                    f"spawn {table.name!r}: {type(handle).__name__} is read-only and cannot be set"
                )
            for field, array in vars(handle._columns).items():
                values[type(handle), field] = np.repeat(array, n, axis=0)
        return self._admit_newborn(table, values, f"spawn {table.name!r}")

    def kill(self, uid: int, cause: str = "culled", killer: int = 0) -> None:
        """Mark an organism to die at the end of the `die` phase.

        An organism that is already marked keeps its first cause.

        Parameters
        ----------
        uid : int
            The organism.
        cause : str, default "culled"
            Cause of death, as shown in records and figures.
        killer : int, default 0
            uid of the organism that killed it; 0 if there is none.

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
        >>> world.spawn("hare", n=2)
        >>> world.flush()
        >>> world.kill(1, cause="shot")
        >>> world.flush()
        >>> hares.n
        1
        """
        table, row = self.locate(uid)
        if not table.cause[row]:
            table.cause[row] = self.cause(cause)
            table.killer[row] = killer

    def locate(self, uid: int) -> tuple[Table, int]:
        """Return the table and the row of a living entity.

        Parameters
        ----------
        uid : int

        Returns
        -------
        table : Table
        row : int
            Valid until the end of the tick.

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
        >>> world.locate(1)
        (<Table 'hare': 1 alive, Position>, 0)
        """
        for table in self.tables.values():
            row = np.flatnonzero(table.uid[: table.high] == uid)
            if row.size and uid > 0:
                return table, int(row[0])
        raise KeyError(f"no living entity has the uid {uid}")

    def get(self, uid: int, component: type[C]) -> C:
        """Return a handle to one organism's component, which reads and writes its row of the columns.

        Parameters
        ----------
        uid : int
        component : type
            A component of its table.

        Returns
        -------
        component
            Valid until the end of the tick.

        Raises
        ------
        KeyError
            If no living entity has this uid, or its table lacks the component.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Metabolism
        >>> world = World()
        >>> hares = world.add_table("hare", Metabolism)
        >>> world.spawn("hare", Metabolism(energy=0.5))
        >>> world.flush()
        >>> world.get(1, Metabolism).energy += 0.25
        >>> float(hares[Metabolism].energy[0])
        0.75
        """
        table, row = self.locate(uid)
        found: C = self._handle(table, row, component)
        return found

    def each(self, *components: type[Any]) -> Iterator[tuple[Any, ...]]:
        """Yield the uids and handles of all living entities that have these components, sorted by uid.

        Entities that are born or die during the loop are skipped.

        Parameters
        ----------
        *components : type

        Yields
        ------
        tuple
            (uid, handle, …), with one handle per component.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Metabolism
        >>> world = World()
        >>> hares = world.add_table("hare", Metabolism)
        >>> world.spawn("hare", Metabolism(energy=0.5), n=2)
        >>> world.flush()
        >>> [(uid, metabolism.energy) for uid, metabolism in world.each(Metabolism)]
        [(1, 0.5), (2, 0.5)]
        """
        living = [
            (int(t.uid[r]), t, int(r)) for t in self.tables.values() if t.has(components) for r in t.rows()
        ]
        for uid, table, row in sorted(living, key=lambda one: one[0]):
            if table.uid[row] != uid:  # it has died or moved to another row
                if not (there := np.flatnonzero(table.uid[: table.high] == uid)).size:
                    continue
                row = int(there[0])
            yield uid, *(self._handle(table, row, component) for component in components)

    def _handle(self, table: Table, row: int, component: type[Any]) -> Any:
        return component.attach(
            table[component] if self.debug is None else self.debug.guard(table, component, row), row
        )

    # --- time ------------------------------------------------------------------------------------------------

    def step(self) -> None:
        """Advance the world by one tick.

        Raises
        ------
        UnfinishedTick
            If an earlier tick was interrupted.

        Examples
        --------
        >>> from ecs_eco import World
        >>> world = World(dt=0.5)
        >>> world.step()
        >>> world.time
        0.5
        """
        self.run(1)

    def stop(self) -> None:
        """Make `run` return after this tick; `stopped` is then true."""
        self.stopping = True

    def run(self, ticks: int, progress: Callable[[int, int], Any] | None = None) -> Self:
        """Advance the world by a number of ticks; see `ecs_eco.World.run`."""
        ticks = whole_number("ticks", ticks)
        called_with("progress", progress, "done", "ticks")
        self._mine()
        require_whole(self, "run")
        self._admit(refuse=self.debug is None)
        self._touch()
        live(self, ticks, progress, Underway("tick"))
        return self

    def _act(self, processors: Iterable[Processor]) -> None:
        """Run processors one after another; in debug mode, check the changes made by each of them."""
        if self.debug is None:
            for processor in processors:
                processor.process()
        else:
            for processor in processors:
                self.debug.act(processor)

    def _pass_tick(self) -> None:
        """Run all processors, dividing work among threads if that has recently been faster."""
        processors = tuple(self.schedule)
        if self.workers.helpers:
            self.workers.tick(lambda: self._act(processors), lambda: sum(t.n for t in self.tables.values()))
        else:
            self._act(processors)

    def _entered(self) -> AbstractContextManager[None]:
        """Return the context for a part of a tick; the esper bridge overrides this."""
        return nullcontext()

    def _mine(self) -> None:
        if threading.get_ident() != self.owner.ident:
            raise RuntimeError(f"only the thread that created a world may use it: {self.owner.name!r}")

    # --- births and deaths -----------------------------------------------------------------------------------

    def flush(self) -> None:
        """Apply all requested deaths, then all requested births.

        `run` does this in every tick, at the ends of the phases `die` and `reproduce`. Call it to apply
        requests made between ticks.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Position
        >>> world = World()
        >>> hares = world.add_table("hare", Position)
        >>> world.spawn("hare", n=2)
        >>> hares.n
        0
        >>> world.flush()
        >>> hares.n
        2
        """
        require_whole(self, "flush", within=True)
        with whole(self, f"the flush before tick {self.tick}"):
            self._flush_deaths()
            self._flush_births()

    def _flush_deaths(self) -> None:
        """Call the hooks for all entities that have a cause of death, sorted by uid, and free their rows."""
        if self.debug is None:
            self.turnover.bury_dying()
        else:
            self.debug.watch(Deaths.label, self.turnover.bury_dying, flush=True)

    def _flush_births(self) -> None:
        """Add the requested newborns, table by table, in request order."""
        if self.debug is None:
            self.turnover.bear()
        else:
            self.debug.watch(Births.label, self.turnover.bear, flush=True)

    def _admit(self, refuse: bool = True) -> None:
        """Check the values that were written between ticks, before kernels read them; worlds with a space
        override this."""

    def _admit_newborn(
        self, table: Table, values: dict[tuple[type, str], Any], label: str
    ) -> dict[tuple[type, str], Any]:
        """Return the checked values of newborns."""
        return values

    # --- for systems -----------------------------------------------------------------------------------------

    def _touch(self) -> None:
        """Invalidate everything derived from positions, because an entity may have been moved through a
        handle."""
        for table in self.tables.values():
            table.version += 1
