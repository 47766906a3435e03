"""Divided state: each process holds only the organisms in its band and, during a tick, nearby ghosts."""

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
EVERY = 32  # ticks between checks of the load balance
UNEVEN = 1.1  # edges move if the load of the heaviest band exceeds the mean load by more than this factor
SEEN = (Position, Body, Traits)  # components copied to ghosts
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
    """An exchange among processes that runs between two systems."""

    def __init__(self, act: Callable[[], None]) -> None:
        self.act = act

    def process(self, *_: object) -> None:
        """Run the exchange."""
        self.act()


class Divided(OneBand):
    """The part of a world held by this process: a band of whole rows of cells. `divide` returns it.

    Before sensing, the process receives ghosts (copies) of all organisms that its own organisms may sense;
    only its own organisms sense, learn and decide. After moving, organisms that crossed an edge change
    process, and the process receives ghosts of all organisms whose meals and matings could affect its own
    organisms. Meals and matings are computed both for the process's own organisms and for ghosts, but are
    reliable only for its own. Births are sent to all processes; the process whose band contains the position
    creates the newborn. Ghosts are removed before the tick ends.
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
        self.moved = 0  # organisms that changed process, and edge moves (`shifts`), since the division
        self.shifts = 0
        self.lessons: list[tuple[int, str, tuple[np.ndarray, ...]]] = []  # not yet collected
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
        for table in self.tables:  # remove organisms that belong to other bands
            table.vacate(table.rows()[~self._is_mine(table, table.rows())])
        self._take_part(world)
        self.early = share_recording(world, comm)  # events recorded before the division

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
        """Before a tick, move the edges if it is worthwhile, and receive ghosts for sensing."""
        if self.world.tick % EVERY == 0:
            self.balance()
        self.copy(self.movers, self.sensing, self.seen)
        self.copy(self.fixed, max(self.sensing, self.acting), self.light)

    def meet(self) -> None:
        """After moving, send organisms that are beyond the edges to other processes, and receive ghosts for
        encounters."""
        if self.movers:
            self.migrate(self.movers)
        self.copy(self.movers, self.acting, self.light)

    def copy(self, tables: Sequence[Table], width: int, columns: Mapping[str, Columns]) -> None:
        """Receive ghosts of all organisms in the tables that are at most `width` rows of cells beyond this
        band."""
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
        """Remove the ghosts of the given tables, or all ghosts."""
        for table in self.tables if tables is None else tables:
            if (rows := self.ghosts[table.name]).size:
                table.vacate(rows)
                self.ghosts[table.name] = rows[:0]

    def migrate(self, tables: Sequence[Table]) -> None:
        """Send organisms outside this band to the processes that own their bands. The tables must have no
        ghosts."""
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
            if (nerves := table.species.nerves) is not None:  # organisms that decided may have moved away
                nerves.rows, nerves.thoughts = table.rows(), None

    def balance(self) -> None:
        """Move the edges if the load is very uneven."""
        load = self.wire.total(self._load())
        rows = self.edges.even(load)
        if self.edges.uneven(load) > UNEVEN and (rows != self.edges.rows).any():
            complete(self.fields, self.wire)
            self.edges.move(rows)
            self.shifts += 1
            self.migrate(self.tables)

    def _load(self) -> np.ndarray:
        """Return the load from this process's organisms in each row of cells: i64[ny]."""
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
        """After decisions, exchange the number of transitions stored by each process in this tick."""
        learning = [rollout for rollout in self.rollouts.values() if rollout.learns]
        if learning:
            stored = np.array([[rollout.stored for rollout in learning]], np.int64)
            (counts,) = self.wire.everyone(stored) if self.processes > 1 else (stored,)
            for rollout, count in zip(learning, counts.T, strict=True):
                rollout.close(count)

    # --- interface for systems ------------------------------------------------------------------------------

    @property
    def common(self) -> OneBand:
        """The processes as a group that shares work on data that each of them holds, such as policies."""
        return self.common_bands

    def own(self, index: Index, *outputs: np.ndarray) -> AbstractContextManager[None]:
        """Within the block, exclude ghosts from `World.split` over the entries or rows of cells of an index."""
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
        """Return the index entries that are not ghosts, which are contiguous."""
        nx = index.space.shape[0]
        first, last = self.edges.rows[self.place], self.edges.rows[self.place + 1]
        return slice(int(index.start[first * nx]), int(index.start[last * nx]))

    def living(self, table: Table) -> np.ndarray:
        """Return whether each row of a table is alive and not a ghost: bool[capacity]."""
        alive: np.ndarray = table.alive.copy()
        alive[self.ghosts[table.name]] = False
        return alive

    def count(self, table: Table) -> int:
        """Return the number of living members of a table in all processes."""
        return int(self.wire.total(np.array([table.n - self.ghosts[table.name].size]))[0])

    def everyone(self, *arrays: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return arrays [n, …] concatenated over all processes, in canonical order if each part is."""
        return self.wire.everyone(*arrays)

    def holds(self, y: np.ndarray) -> np.ndarray | None:
        """Return whether each position y f32[n] [m] is in this band: bool[n]."""
        return self.edges.owner_of(y) == self.place

    def either(self, flags: np.ndarray) -> np.ndarray:
        """Return whether each flag is set in at least one process: bool[…]."""
        return self.wire.any(flags)

    def litters(self, litters: Any, where: Any) -> Any:
        """Return the litters of all processes and their possible positions, sorted by the parents' uids."""
        return self.births.litters(litters, where)

    def inherited(self, *arguments: Any) -> Any:
        """Return the columns that newborns inherit from parents in any process."""
        return self.births.inherited(*arguments)

    def sites(self, table: Table, stands: np.ndarray) -> np.ndarray:
        """Return the uid of the plant on each site, or −1 if the site is empty: i64[ny, nx]."""
        return self.births.sites_of(table, stands.shape)

    def learnt(self, minds: object, *arrays: np.ndarray) -> tuple[np.ndarray, ...]:
        """Store this tick's learning statistics, one entry per individual, for the record; return them."""
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
        """Request a stop, which takes effect when all processes agree."""
        self.talk.wishes = True
        return False

    def agree(self) -> bool:
        """Serve requests from process 0, and return whether any process has been asked to stop."""
        return self.talk.go_on()

    def undivided(self, world: T) -> T | None:
        """Return the whole world in process 0, and None in the other processes."""
        return self.talk.undivided()

    def ask(self, what: Callable[[Any], Any]) -> Any:
        """Apply a function to the whole world and return its value in every process that asks for it."""
        return self.talk.ask(what)

    def collect(self, recorder: Any) -> None:
        """Send all records since the last collection to process 0."""
        self.talk.collect(recorder)

    @property
    def traffic(self) -> Traffic:
        """Communication statistics of this process."""
        one, other = self.wire.traffic, self.common_bands.traffic
        return Traffic(one.calls + other.calls, one.received + other.received, one.seconds + other.seconds)
