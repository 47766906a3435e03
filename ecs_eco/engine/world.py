"""A World: tables of organisms, a clock, and systems in phases. It knows neither space nor biology nor esper."""

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

    `dt` [s] is the length of a tick, `seed` all chance. `threads` changes the speed and no result.

    Hooks are lists of functions: `before_tick` (no arguments, before each tick of `run`), `on_death` (table,
    rows), before the rows are freed, and `on_birth` (table, rows, uids of first and of second parents, 0 for
    none), once the rows are filled; of migrants `on_departure` (table, rows, numbers of the islands that they
    leave for) and `on_arrival` (table, rows, numbers of those that they come from). They are called in the
    order of the list, as it was when the event happened: a hook may remove itself. None of them is saved.
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
        self.ticking = False  # whether a tick is under way
        self.stopping = False  # whether `run` is to return, as soon as it can
        self.stopped = False  # whether the last `run` returned early
        # an action that has begun and is not complete, or never will be
        self.underway: Underway | None = None
        self.debug: Any = None  # the checks of the debug mode
        self.owner = threading.current_thread()  # it alone touches the world
        self.workers = Workers(self.threads)
        # kernel, n, *arguments, work=None: runs `kernel(first, last, *arguments)` over 0…n, on all threads where
        # `work` items are worth it
        self.split: Callable[..., None] = self.workers.split
        # pieces of work that do not depend on each other: does them, on all threads where it pays; no two may write
        # to the same array
        self.together: Callable[..., None] = partial(self.workers.together, self.tables.values())
        self.schedule = Schedule()
        self.turnover = Turnover(self)  # how births and deaths take effect
        self._places = 0  # in the phases, that systems have taken
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
        """Seconds since the start."""
        return self.tick * self.dt

    @property
    def key(self) -> np.uint64:
        """The key of this tick's random numbers."""
        return random.tick_key(self.seed, self.tick)

    # --- what there is --------------------------------------------------------------------------------------

    def add_table(
        self, name: str, *components: type[Any], capacity: int = 64, dims: Mapping[str, int] | None = None
    ) -> Table:
        """Declare a kind of entity with these components; `dims` gives the sizes that their shapes name."""
        if name in self.tables:
            raise ValueError(f"table {name!r} exists already; choose another name")
        table = self.tables[name] = Table(
            name, components, capacity=capacity, dims=dims, place=len(self.tables)
        )
        return table

    def add_system(self, system: Processor, phase: str | None = None, priority: int | None = None) -> Any:
        """Add a system at the end of its phase; a plain esper.Processor goes
        to `interact` unless `phase` says otherwise.

        `priority`, in the place of a phase, is its place among all processors as esper counts, from 0 down,
        a million for each phase.
        """
        phase = phase or getattr(system, "phase", "interact")
        if not isinstance(system, Processor):
            raise TypeError(
                f"system {system!r} is no ecs_eco.System or esper.Processor; "
                "hand in an instance, as in Move()"
            )
        if phase not in PHASES:
            raise ValueError(unknown_name(f"system {type(system).__name__}", "phase", phase, PHASES))
        if getattr(system, "world", None) is not None:
            raise ValueError(
                f"system {type(system).__name__} is in a world already; make another instance for this one"
            )
        system.phase = phase  # type: ignore[attr-defined]
        # esper keeps the system: it must not keep the world
        system.world = weakref.proxy(self)  # type: ignore[attr-defined]
        self.systems.append(system)  # type: ignore[arg-type]
        self._places += 1
        place = priority_of(phase, self._places) if priority is None else priority
        self.schedule.put(system, place)
        if isinstance(system, Scheduled):
            system.start(self)
        else:  # it may move what it sees through esper
            self.schedule.put(Touched(self, system), place)
        return system

    def remove_processor(self, processor: Processor) -> None:
        """Take a plain esper.Processor out of the schedule again; RuntimeError for a system,
        which others count on."""
        if isinstance(processor, Scheduled) or processor not in self.systems:
            raise RuntimeError(
                f"world {self.name!r}: {type(processor).__name__} is part of its schedule "
                "and stays; "
                "build a world without it, or let a system of your own take its place"
            )
        for one in [p for p in self.schedule if p is processor or getattr(p, "after", None) is processor]:
            self.schedule.remove(one)
        self.systems.remove(processor)

    def table(self, name: str) -> Table:
        """Return the table of this name; KeyError names the nearest."""
        try:
            return self.tables[name]
        except KeyError:
            raise UnknownName(unknown_name("world", "table", name, self.tables)) from None

    def cause(self, name: str) -> int:
        """Return the code of a cause of death, making it known where it is new."""
        return self.codes[name]

    def spawn(self, name: str, *components: object, n: int = 1, parent: int = 0) -> None:
        """Ask for `n` newborn of a kind, with these components' values (the table's defaults for the others).

        They come to life at the end of the phase `reproduce`, or at `flush`. A place beyond the edge of a
        torus is brought back around it. Raises ValueError for one outside of a world with walls, and for any
        value beyond the limits of its field.
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
        """Return what `n` newborn with these components are born with, as it may come to life."""
        values = {}
        for handle in components:
            if type(handle) not in table:
                table[type(handle)]  # raises the error that names what there is
            if type(handle) in table.derived:
                raise TypeError(
                    f"spawn {table.name!r}: {type(handle).__name__} is read, not written: "
                    "nobody is born with it"
                )
            for field, array in vars(handle._columns).items():
                values[type(handle), field] = np.repeat(array, n, axis=0)
        return self.admit_newborn(table, values, f"spawn {table.name!r}")

    def kill(self, uid: int, cause: str = "culled", killer: int = 0) -> None:
        """Let the organism `uid` die of a cause at the end of the phase `die`. Killing twice changes nothing."""
        table, row = self.locate(uid)
        if not table.cause[row]:
            table.cause[row] = self.cause(cause)
            table.killer[row] = killer

    def locate(self, uid: int) -> tuple[Table, int]:
        """Return the table and the row of a living entity; KeyError where there is none."""
        for table in self.tables.values():
            row = np.flatnonzero(table.uid[: table.high] == uid)
            if row.size and uid > 0:
                return table, int(row[0])
        raise KeyError(f"no living entity has the uid {uid}")

    def get(self, uid: int, component: type[C]) -> C:
        """Return the handle of one living entity's component."""
        table, row = self.locate(uid)
        found: C = self._handle(table, row, component)
        return found

    def each(self, *components: type[Any]) -> Iterator[tuple[Any, ...]]:
        """Yield (uid, handle, …) for all living entities that have these components, in the order of uids;
        not for those that die or are born within the loop."""
        living = [
            (int(t.uid[r]), t, int(r)) for t in self.tables.values() if t.has(components) for r in t.rows()
        ]
        for uid, table, row in sorted(living, key=lambda one: one[0]):
            if table.uid[row] != uid:  # it has died, or is in another row now
                if not (there := np.flatnonzero(table.uid[: table.high] == uid)).size:
                    continue
                row = int(there[0])
            yield uid, *(self._handle(table, row, component) for component in components)

    def _handle(self, table: Table, row: int, component: type[Any]) -> Any:
        return component.attach(
            table[component] if self.debug is None else self.debug.guard(table, component, row), row
        )

    # --- time -----------------------------------------------------------------------------------------------

    def step(self) -> None:
        """Let one tick pass."""
        self.run(1)

    def stop(self) -> None:
        """Make `run` return after this tick, or before the next if none is under way; `stopped` is then true."""
        self.stopping = True

    def run(self, ticks: int, progress: Callable[[int, int], Any] | None = None) -> Self:
        """Let `ticks` ticks pass; `progress(done, ticks)` is called about ten times a second.

        Returns the world. Returns early, after a whole tick, if `stop()` was called. The functions in
        `before_tick` are called before every tick. Ctrl-C also stops after a whole tick. An error within a
        tick, or a second Ctrl-C, leaves a world that can only be inspected: anything else raises
        UnfinishedTick.
        """
        ticks = whole_number("ticks", ticks)
        called_with("progress", progress, "done", "ticks")
        self._mine()
        require_whole(self, "run")
        self.admit(refuse=self.debug is None)
        self.touch()
        live(self, ticks, progress, Underway("tick"))
        return self

    def act(self, processors: Iterable[Processor]) -> None:
        """Let processors act, one after the other; in the debug mode what each of them did is checked."""
        if self.debug is None:
            for processor in processors:
                processor.process()
        else:
            for processor in processors:
                self.debug.act(processor)

    def pass_tick(self) -> None:
        """Let all processors act, in the way of dividing work among threads that took less time lately."""
        processors = tuple(self.schedule)
        if self.workers.helpers:
            self.workers.tick(lambda: self.act(processors), lambda: sum(t.n for t in self.tables.values()))
        else:
            self.act(processors)

    def entered(self) -> AbstractContextManager[None]:
        """Return what a part of a tick takes place within; a world that others can look into says more."""
        return nullcontext()

    def _mine(self) -> None:
        if threading.get_ident() != self.owner.ident:
            raise RuntimeError(f"one thread alone touches a world: the one that made it, {self.owner.name!r}")

    # --- births and deaths ----------------------------------------------------------------------------------

    def flush(self) -> None:
        """Carry out the deaths, then the births asked for so far."""
        require_whole(self, "flush", within=True)
        with whole(self, f"the flush before tick {self.tick}"):
            self.flush_deaths()
            self.flush_births()

    def flush_deaths(self) -> None:
        """Free the rows of all that have a cause of death; hooks see them first, in the order of uids."""
        if self.debug is None:
            self.turnover.bury_dying()
        else:
            self.debug.watch(Deaths.label, self.turnover.bury_dying, flush=True)

    def flush_births(self) -> None:
        """Bring the newborn that were asked for to life, table by table, in the order of their requests."""
        if self.debug is None:
            self.turnover.bear()
        else:
            self.debug.watch(Births.label, self.turnover.bear, flush=True)

    def admit(self, refuse: bool = True) -> None:
        """Check what was written between ticks, before kernels read it; a world with a space does this."""

    def admit_newborn(
        self, table: Table, values: dict[tuple[type, str], Any], label: str
    ) -> dict[tuple[type, str], Any]:
        """Return the values of newborn as they may come to life."""
        return values

    # --- for systems ----------------------------------------------------------------------------------------

    def touch(self) -> None:
        """Invalidate all that is derived from positions: handles may have moved something."""
        for table in self.tables.values():
            table.version += 1
