"""Divided state: each process holds only the organisms of its band and, within a tick, ghosts beyond it."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

import esper
import numpy as np

from ecs_eco.bands.bands import Bands, Traffic
from ecs_eco.bands.births import Births
from ecs_eco.bands.edges import Edges
from ecs_eco.bands.exchange import Columns, Wire, columns_of, packed, settled
from ecs_eco.bands.fields import BandField, complete, trade
from ecs_eco.bands.records import share_recording
from ecs_eco.bands.rollout import BandRollout
from ecs_eco.bands.talk import Talk
from ecs_eco.bands.widths import Widths, least_height
from ecs_eco.components import Body, Position, Traits, Velocity
from ecs_eco.engine.phases import LAST, priority_of
from ecs_eco.space.one_band import OneBand

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mpi4py.MPI import Comm

    from ecs_eco.ecosystem import World
    from ecs_eco.engine.table import Table
    from ecs_eco.space.index import Index

T = TypeVar("T")
EVERY = 32  # ticks between two checks of the load balance
UNEVEN = 1.1  # load of the heaviest band, relative to the mean, above which edges move
SEEN = (Position, Body, Traits)  # components of ghosts
MIND = 10  # load of an organism that senses and decides, relative to one that does not


def stays(table: Table) -> bool:
    """Return whether the members of a table never move, so that their ghosts stay valid for the tick."""
    species = table.species
    return (
        Velocity not in table
        and species.nerves is None
        and species.motion is None
        and not species.body.sinking
    )


class Step(esper.Processor):
    """An exchange between processes, between two systems."""

    def __init__(self, act: Callable[[], None]) -> None:
        self.act = act

    def process(self, *_: object) -> None:
        """Run the exchange."""
        self.act()


class Divided(OneBand):
    """The part of a world that this process holds, a band of whole rows of cells; `divide` returns it.

    Before sensing, it receives ghosts of all organisms that its own may sense; only its own sense, learn and
    decide. After moving, organisms beyond an edge change process, and ghosts arrive of all whose meals and
    matings could affect its own. Meals and matings are computed for both, and are correct for its own. Births
    are sent to all processes; the one of the place creates the newborn. Ghosts are removed before the tick
    ends.
    """

    divided = True

    def __init__(self, world: World, comm: Comm, widths: Widths) -> None:
        self.world: Any = weakref.proxy(world)
        self.common_bands = Bands(world, comm)
        self.wire = Wire(comm)
        self.processes, self.place = self.wire.size, self.wire.rank
        self.widths, (self.sensing, self.acting) = widths, widths.rows(world)
        self.edges = Edges(world.space, self.processes, least_height(world, widths))
        self.tables = [table for table in world.tables.values() if Position in table]
        self.ghosts = {table.name: np.zeros(0, np.int64) for table in self.tables}
        self.births, self.talk = Births(self, world), Talk(self)
        self.fixed = [table for table in self.tables if stays(table)]
        self.movers = [table for table in self.tables if table not in self.fixed]
        self.all, self.light = (
            {table.name: columns_of(table, heavy) for table in self.tables} for heavy in (True, False)
        )
        self.seen = {
            table.name: columns_of(table, False, None if widths.properties else SEEN) for table in self.movers
        }
        self.copied = 0  # ghosts
        self.moved = 0  # organisms that changed their process, and moves of edges, since the division
        self.shifts = 0
        self.lessons: list[tuple[int, str, tuple[np.ndarray, ...]]] = []  # of individuals, not yet collected
        self.edges.move(self.edges.even(self._load()))
        self.fields = [
            BandField(field, self.edges, self.place, halo)
            for field, halo in zip(world.fields.values(), widths.halos, strict=True)
        ]
        self.rollouts = {
            table.name: BandRollout.of(table, self.wire, partial(self._is_mine, table))
            for table in self.tables
            if table.species.nerves is not None and table.species.nerves.learner is not None
        }
        for table in self.tables:  # organisms of other bands
            table.vacate(table.rows()[~self._is_mine(table, table.rows())])
        self._take_part(world)
        self.early = share_recording(world, comm)  # events before the division

    def _take_part(self, world: World) -> None:
        """Insert exchanges between the systems of a tick, and replace the handling of births and deaths."""
        put = world.schedule.put
        put(Step(self.look_around), priority_of("environment", 0))
        for system in world.systems:
            if type(system).__name__ == "Diffuse":
                put(Step(lambda: trade(self.fields, self.wire)), system.priority)
        put(Step(self.close_rollouts), priority_of("decide", LAST))
        put(Step(partial(self.forget, self.movers)), priority_of("move", 0))
        put(Step(self.meet), priority_of("move", LAST))
        world.turnover = self.births

    # --- ghosts ---------------------------------------------------------------------------------------------

    def look_around(self) -> None:
        """Before a tick: move the edges if that is worthwhile, and receive ghosts for sensing."""
        if self.world.tick % EVERY == 0:
            self.balance()
        self.copy(self.movers, self.sensing, self.seen)
        self.copy(self.fixed, max(self.sensing, self.acting), self.light)

    def meet(self) -> None:
        """After moving: send organisms beyond the edges away, and receive ghosts for encounters."""
        if self.movers:
            self.migrate(self.movers)
        self.copy(self.movers, self.acting, self.light)

    def copy(self, tables: Sequence[Table], width: int, columns: Mapping[str, Columns]) -> None:
        """Receive ghosts of all organisms in some tables at most `width` rows of cells beyond this band."""
        if not tables:
            return
        rows = [table.rows() for table in tables]
        cells = [self._cells(table, r) for table, r in zip(tables, rows, strict=True)]
        parts = {
            rank: packed(
                [(table, r[near[c]]) for table, r, c in zip(tables, rows, cells, strict=True)], columns
            )
            for rank, near in self.edges.near(self.place, width).items()
        }
        for _, data in sorted(self.wire.swap(parts).items()):
            for table, came in zip(tables, settled(tables, data, columns)[0], strict=True):
                self.ghosts[table.name] = np.concatenate([self.ghosts[table.name], came])
                self.copied += came.size

    def forget(self, tables: Sequence[Table] | None = None) -> None:
        """Remove all ghosts, or the ghosts of some tables."""
        for table in self.tables if tables is None else tables:
            if (rows := self.ghosts[table.name]).size:
                table.vacate(rows)
                self.ghosts[table.name] = rows[:0]

    def migrate(self, tables: Sequence[Table]) -> None:
        """Send organisms of some tables that are outside this band to the processes of their bands. These
        tables must not have ghosts."""
        parts, leaving = {}, []
        for table in tables:
            rows = table.rows()
            owner = self.edges.owner[self._cells(table, rows)]
            away = owner != self.place
            leaving.append((table, rows[away], owner[away]))
        for rank in np.unique(np.concatenate([owner for _, _, owner in leaving])).tolist():
            going = [(table, rows[owner == rank]) for table, rows, owner in leaving]
            records = [
                self.rollouts[table.name].take(rows) for table, rows in going if table.name in self.rollouts
            ]
            parts[rank] = np.concatenate([packed(going, self.all), *records])
        for table, rows, _ in leaving:
            self.moved += rows.size
            if rows.size:
                table.vacate(rows)
        for _, data in sorted(self.wire.swap(parts).items()):
            came, rest = settled(tables, data, self.all)
            for table, rows in zip(tables, came, strict=True):
                if table.name in self.rollouts:
                    rest = self.rollouts[table.name].give(rows, rest)
        for table in tables:
            if (nerves := table.species.nerves) is not None:  # deciders may have moved away
                nerves.rows, nerves.thoughts = table.rows(), None

    def balance(self) -> None:
        """Move the edges if some bands have a much higher load than others."""
        load = self.wire.total(self._load())
        rows = self.edges.even(load)
        if self.edges.uneven(load) > UNEVEN and (rows != self.edges.rows).any():
            complete(self.fields, self.wire)
            self.edges.move(rows)
            self.shifts += 1
            self.migrate(self.tables)

    def _load(self) -> np.ndarray:
        """Return the load of each row of cells from the organisms of this process: i64[ny]."""
        load = np.zeros(self.edges.ny, np.int64)
        for table in self.tables:
            each = 1 if table.species.nerves is None else MIND
            load += each * np.bincount(self._cells(table, table.rows()), minlength=self.edges.ny)
        return load

    def _cells(self, table: Table, rows: np.ndarray) -> np.ndarray:
        return self.edges.row_of(table[Position].y[rows])

    def _is_mine(self, table: Table, rows: np.ndarray) -> np.ndarray:
        mine: np.ndarray = self.edges.owner[self._cells(table, rows)] == self.place
        return mine

    def close_rollouts(self) -> None:
        """After deciding: exchange how many transitions each process has stored in this tick."""
        learning = [rollout for rollout in self.rollouts.values() if rollout.learns]
        if learning:
            stored = np.array([[rollout.stored for rollout in learning]], np.int64)
            (counts,) = self.wire.everyone(stored) if self.processes > 1 else (stored,)
            for rollout, count in zip(learning, counts.T, strict=True):
                rollout.close(count)

    # --- interface for systems ------------------------------------------------------------------------------

    @property
    def common(self) -> OneBand:
        """The processes as a group that shares work on data that all of them hold: policies and rollouts."""
        return self.common_bands

    def own(self, index: Index, *outputs: np.ndarray) -> AbstractContextManager[None]:
        """Exclude ghosts from `World.split` over an index's entries or rows of cells, within the block."""
        if self.processes == 1 or index.n == self.edges.ny:  # the two cases are indistinguishable
            return nullcontext()
        return self._own(index)

    @contextmanager
    def _own(self, index: Index) -> Iterator[None]:
        workers, here = self.common_bands.workers, self.entries(index)
        rows = self.edges.rows[self.place : self.place + 2]
        parts = {self.edges.ny: (int(rows[0]), int(rows[1])), index.n: (here.start, here.stop)}
        workers.own = lambda n: parts.get(n, (0, n))
        try:
            yield
        finally:
            workers.own = None

    def entries(self, index: Index) -> slice:
        """Return the entries of an index that are not ghosts; they are contiguous."""
        nx = index.space.shape[0]
        first, last = self.edges.rows[self.place], self.edges.rows[self.place + 1]
        return slice(int(index.start[first * nx]), int(index.start[last * nx]))

    def living(self, table: Table) -> np.ndarray:
        """Return which rows of a table are alive and not ghosts: bool[capacity]."""
        alive: np.ndarray = table.alive.copy()
        alive[self.ghosts[table.name]] = False
        return alive

    def count(self, table: Table) -> int:
        """Return the number of living members of a table in all processes."""
        return int(self.wire.total(np.array([table.n - self.ghosts[table.name].size]))[0])

    def everyone(self, *arrays: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return arrays [n, …] concatenated over all processes. They are in canonical order if each part
        is."""
        return self.wire.everyone(*arrays)

    def holds(self, y: np.ndarray) -> np.ndarray | None:
        """Return which places f32[n] [m] are in this band: bool[n]."""
        return self.edges.owner_of(y) == self.place

    def either(self, flags: np.ndarray) -> np.ndarray:
        """Return which flags bool[…] are set in any process."""
        return self.wire.any(flags)

    def litters(self, litters: Any, where: Any) -> Any:
        """Return the litters of all processes, ordered by their parents' uids, and their possible places."""
        return self.births.litters(litters, where)

    def inherited(self, *arguments: Any) -> Any:
        """Return the columns that newborns inherit from parents in any process."""
        return self.births.inherited(*arguments)

    def sites(self, table: Table, stands: np.ndarray) -> np.ndarray:
        """Return the uid of the plant on each site i64[ny, nx], −1 if the site is empty."""
        return self.births.sites_of(table, stands.shape)

    def learnt(self, minds: object, *arrays: np.ndarray) -> tuple[np.ndarray, ...]:
        """Store what individuals have learned in this tick, one entry each, for the record; return it."""
        if len(arrays[0]) and self.world.recorder is not None:
            name = next(
                t.name
                for t in self.tables
                if t.species.nerves is not None and t.species.nerves.individuals is minds
            )
            self.lessons.append((self.world.tick, name, arrays))
        return arrays

    # --- stopping together ----------------------------------------------------------------------------------

    def stops(self) -> bool:
        """Note that this process should stop, and wait for the others to agree."""
        self.talk.wishes = True
        return False

    def agree(self) -> bool:
        """Serve the requests of process 0; return whether any process has been asked to stop."""
        return self.talk.go_on()

    def undivided(self, world: T) -> T | None:
        """Return the whole world in process 0, None in the others."""
        return self.talk.undivided()

    def ask(self, what: Callable[[Any], Any]) -> Any:
        """Return the value of a function of the whole world, in all processes that ask for it."""
        return self.talk.ask(what)

    def collect(self, recorder: Any) -> None:
        """Send the records since the last collection from all processes to process 0."""
        self.talk.collect(recorder)

    @property
    def traffic(self) -> Traffic:
        """Communication of this process."""
        one, other = self.wire.traffic, self.common_bands.traffic
        return Traffic(one.calls + other.calls, one.received + other.received, one.seconds + other.seconds)
