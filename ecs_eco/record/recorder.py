"""The recorder: one row for each tick and species, with the energy ledger and causes of death and, on
request, every birth and death."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Metabolism, Nervous, Position
from ecs_eco.engine.addresses import Addresses
from ecs_eco.engine.interruption import require_whole
from ecs_eco.engine.system import System
from ecs_eco.life.matter import is_island
from ecs_eco.record.details import Details, how_many
from ecs_eco.record.events import EVENTS, MIGRATION, Migrations, as_numbers, as_text
from ecs_eco.record.fields import Fields
from ecs_eco.record.frame import as_table, joined, under
from ecs_eco.record.genomes import has_text, letters_of, texts_of
from ecs_eco.record.learning import LearningPages
from ecs_eco.record.ledger import COUNTS_ROW, ISLAND_COUNTS_ROW, ISLAND_LEDGER_ROW, LEDGER_ROW
from ecs_eco.record.matter import MatterPages
from ecs_eco.record.reports import Intake, Reports
from ecs_eco.record.rows import (
    REFUSED,
    Rows,
    add_up,
    as_plain,
    as_rows,
    held_by,
    mean_depth,
    note_births,
    note_deaths,
    noted_of,
    stock_of,
)

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

MOST_SPECIES = 128  # species numbers are stored as i8


class Recorder(System):
    """Records the changes in each species in every tick.

    Parameters
    ----------
    world : World
    sink : callable, optional
        `sink(kind, columns)` receives finished blocks of "series", "births", "deaths" and "snapshots"; default:
        series stay in memory.
    block : int, default 1000
        Ticks per block.
    snapshot_every : int, default 0
        Ticks between two snapshots of all organisms; 0: no snapshots.
    keep_events : bool, default False
        Whether to keep births and deaths in memory, for `events`.
    record : str, optional
        Details of individual organisms for the sink: "focal=N" or "full" (`ecs_eco.record.details`).

    Notes
    -----
    The energy ledger closes: stock after = stock before + endowed + taken in − burned − given − lost
    (on islands, + imported − exported), summed in float64. Organisms alive when the recording begins are
    recorded as births at the tick of their birth, with parent 0.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.record import Recorder
    >>> world = World.from_config("predator-prey", seed=1, record=False)
    >>> recorder = Recorder(world)
    >>> world.run(3).series().num_rows
    9
    >>> recorder.flush()
    >>> recorder.learning_series().num_rows, recorder.action_series().num_rows
    (0, 0)
    """

    phase = "record"
    divisible = True
    world: "SpatialWorld"

    def __init__(
        self,
        world: "SpatialWorld",
        sink: Callable[[str, dict[str, np.ndarray]], None] | None = None,
        *,
        block: int = 1000,
        snapshot_every: int = 0,
        keep_events: bool = False,
        record: str | None = None,
    ) -> None:
        require_whole(world, "record")
        most = how_many(record, "Recorder: record")
        if most != 0 and sink is None:
            raise ValueError(f"Recorder: record is {record!r}, but there is no sink to receive the details")
        if keep_events and sink is not None:
            raise ValueError(
                "Recorder: keep_events is True, but a sink receives the events; use only one of the two"
            )
        self.sink, self.block, self.snapshot_every = sink, block, snapshot_every
        self.keeps = keep_events or sink is not None
        self.names, self.began = world.species_names(), world.config  # at the start of the recording
        if (s := len(self.names)) > MOST_SPECIES:
            raise ValueError(f"Recorder: the world has {s} species; expected at most {MOST_SPECIES}")
        self.place = {name: i for i, name in enumerate(self.names)}
        self._tick = np.zeros((block, s), np.int64)
        island = is_island(world)
        self._counts = np.zeros((block, s), ISLAND_COUNTS_ROW if island else COUNTS_ROW)
        self.means = ("energy_mean", "happiness_mean", *(("depth_mean",) if world.space.volume else ()))
        self._numbers = self._counts.view(np.int32).reshape(block, s, -1)  # a view, by COUNTS_ROW
        self._means = np.zeros((block, s), np.dtype([(name, np.float32) for name in self.means]))
        self._moods, self._high = np.zeros((block, s)), np.zeros(s, np.int64)  # sums of happiness
        self._ledger = np.zeros((block, s), ISLAND_LEDGER_ROW if island else LEDGER_ROW)
        self._sums = self._ledger.view(np.float64).reshape(block, s, -1)  # a view, by LEDGER
        tables = [world.tables[name] for name in self.names]
        self._held = Addresses(lambda: [held_by(table) for table in tables])
        self._noted = Addresses(lambda: [noted_of(table) for table in tables])
        self._died, self._stock = np.zeros((block, s, 256), np.int32), np.array([stock_of(t) for t in tables])
        self._both = self._means.view(np.float32).reshape(block, s, -1)  # a view, of energy and happiness
        self._at, self._last = 0, -1  # the row to write next; the last finished tick
        self._blocks: list[dict[str, np.ndarray]] = []
        self.remembered: int | None = None  # blocks kept in memory; None: all if there is no sink, else none
        self.fields = Fields(world, self.names)  # additional columns of events
        self.columns = {kind: (*names, *self.fields.names) for kind, names in EVENTS.items()}
        self._events = {kind: [] for kind in EVENTS}
        # by species with a genome: the letter of each number, "S1" or "U1"
        self._letters: dict[str, np.ndarray] = {}
        self.details = None if most == 0 else Details(world, most, sink)
        self.matter = None if world.matter is None else MatterPages(world)
        self.learning = LearningPages(world, self.names)
        both: dict[str, Any] = {"learning": self.learning, "matter": self.matter}
        self._pages = {kind: pages for kind, pages in both.items() if pages is not None}
        self.reports = Reports(world, self.names, block) if world.reporters else None
        self.intake = Intake(world, self.names, block, self._sums.shape[-1])
        world.on_birth.append(self.born)
        world.on_death.append(self.died)
        self.migrations = Migrations(self, world) if island else None
        for table in tables:
            table.species.refused = 0
        world.recorder = self
        world.add_system(self)

    def start(self, world: "SpatialWorld") -> None:
        """Record the founders."""
        for table, s in self._in_turn() if self.keeps else ():
            rows = table.by_uid()
            none = np.zeros(rows.size, np.uint64)
            more = none, none, self._genomes(table, rows), *self.fields.of(table, rows)
            self._events["births"].append((*self._where(table, s, rows, table.born[rows]), *more))

    def _in_turn(self) -> list[tuple["Table", int]]:
        """Return the tables with members and the indices of their species, in recording order."""
        return [(t, self.place[name]) for name, t in self.world.tables.items() if t.n and name in self.place]

    def born(self, table: "Table", rows: np.ndarray, parents: np.ndarray, second: np.ndarray) -> None:
        """Record newborns in rows i64[k], with their parents' uids u64[k]."""
        if self.details is not None:
            self.details.born(table, rows)
        s = self.place.get(table.name)
        if s is None:
            return
        wide = has_text(table) or bool(self.fields.names)  # columns that kernels do not record
        into = self._rows["births"] if self.keeps and not wide else None
        page, columns = self._sums[self._at], self._noted()[s]
        self._numbers[self._at, s, 1] += rows.size
        note_births(table, columns, rows, parents, second, self.world.tick, s, page, into)
        if self.keeps and wide:
            more = parents, second, self._genomes(table, rows), *self.fields.of(table, rows)
            self._events["births"].append((*self._where(table, s, rows), *more))

    def died(self, table: "Table", rows: np.ndarray) -> None:
        """Record the flows and the remaining energy of dying organisms before their rows are freed."""
        if self.details is not None:
            self.details.died(table, rows, self.world)
        s = self.place.get(table.name)
        if s is None:
            return
        at, world, columns = self._at, self.world, self._noted()[s]
        into = self._rows["deaths"] if self.keeps and not self.fields.names else None
        when = world.tick, world.dt, world.ticking
        self._numbers[at, s, 2] += rows.size
        note_deaths(table, columns, rows, *when, s, self._sums[at], self._died[at, s], into)
        if self.keeps and self.fields.names:
            age = ((world.tick - table.born[rows]) * world.dt).astype(np.float32)
            more = table.cause[rows], table.killer[rows], age, *self.fields.of(table, rows)
            self._events["deaths"].append((*self._where(table, s, rows), *more))

    @property
    def _events(self) -> dict[str, list[tuple[np.ndarray, ...]]]:
        """Return the pending events of each kind, with the columns of EVENTS."""
        for kind, rows in self._rows.items():
            if rows.n:
                self._groups[kind] += rows.taken(kind, self._last)
        return self._groups

    @_events.setter
    def _events(self, groups: dict[str, list[tuple[np.ndarray, ...]]]) -> None:
        self._groups, self._rows = groups, {"births": Rows(), "deaths": Rows()}

    def _genomes(self, table: "Table", rows: np.ndarray) -> np.ndarray:
        """Return the genomes of rows as text (see `texts_of`)."""
        if table.name not in self._letters:
            self._letters[table.name] = letters_of(table)
        return texts_of(table, rows, self._letters[table.name])

    def _where(
        self, table: "Table", s: int, rows: np.ndarray, tick: np.ndarray | None = None
    ) -> tuple[np.ndarray, ...]:
        zero, which = np.zeros(rows.size, np.float32), np.full(rows.size, s, np.int8)
        at = [getattr(table[Position], axis)[rows] if Position in table else zero for axis in "xyz"]
        tick = np.full(rows.size, self.world.tick) if tick is None else tick
        energy = table[Metabolism].energy[rows] if Metabolism in table else zero
        return tick, which, table.uid[rows], *at, energy

    def process(self, *_: Any) -> None:
        """Write this tick's row for each species."""
        at, world = self._at, self.world
        self._tick[at] = world.tick
        pages, living, high, rows = self._sums[at], self._numbers[at], self._high, 0
        for s, name in enumerate(self.names):
            table = world.tables[name]
            living[s, 0], high[s] = table.n, table.high
            living[s, REFUSED], table.species.refused = table.species.refused, 0
            rows += table.high
            if world.space.volume and Position in table and table.n:
                self._means["depth_mean"][at, s] = mean_depth(
                    table.alive[: table.high], table[Position].z, float(world.space.size[2])
                )
        into = self._stock, pages, self._both[at], self._moods[at]
        intake = self.intake.gained(at), self.intake.total, self.intake.flows
        work = rows // 15  # each row takes a fifth of the usual time
        world.split(add_up, len(self.names), self._held(), high, living, *into, *intake, work=work)
        if self.snapshot_every and world.tick % self.snapshot_every == 0:
            self._snapshot(world.tick)
        if self.details is not None:
            self.details.note(world)
        for others in self._pages.values():
            others.turn(world)
        if self.reports is not None:
            self.reports.note(world, at)
        self._at, self._last = self._at + 1, world.tick
        if self._at == self.block:
            self.flush()

    def _snapshot(self, tick: int) -> None:
        for table, s in self._in_turn():
            if Position in table:
                rows = table.by_uid()
                zero = np.zeros(rows.size, np.float32)
                mood = table[Nervous].happiness[rows] if Nervous in table else zero
                more = table[Position].heading[rows], mood, *self.fields.of(table, rows)
                at = self._where(table, s, rows, np.full(rows.size, tick))
                self._events["snapshots"].append((*at, *more))

    def flush(self) -> None:
        """Pass the records of all finished ticks to the sink, or keep them in memory.

        Returns
        -------
        None
        """
        self.world.bands.collect(self)
        if self._at:
            block = self._columns(self._at)
            if self.sink is not None:
                self.sink("series", block)
            if self.sink is None or self.remembered:
                self._blocks.append(block)
                del self._blocks[: -self.remembered if self.remembered else 0]
            for pages in self._pages.values():
                pages.flush(self.sink)
            for array in (self._counts, self._means, self._ledger, self._moods, self._died):
                # the page of an unfinished tick
                begun = array[self._at].copy() if self._at < self.block else 0
                array[...] = 0
                array[0] = begun
            self._at = 0
        if self.details is not None:
            self.details.flush(self.world)
        if self.sink is not None:
            for kind, groups in self._events.items():
                over = [e for e in groups if e[0][0] <= self._last]
                self._groups[kind] = groups[len(over) :]
                if over:
                    self.sink(kind, self._together(kind, over))

    @contextmanager
    def written_to(self, sink: Callable[[str, dict[str, np.ndarray]], None]) -> Iterator[None]:
        """Pass the records in memory to `sink`, and new ones within the block; then restore those in memory."""
        self.flush()
        kept = self._blocks, {kind: list(groups) for kind, groups in self._events.items()}
        pages, blocks = self._pages.values(), [each.blocks for each in self._pages.values()]
        for kind, columns in (
            (k, c) for of in ({"series": self._blocks}, *blocks) for k in of for c in of[k]
        ):
            sink(kind, columns)
        self.sink, self._blocks = sink, []
        for each in pages:
            each.blocks = {kind: [] for kind in each.blocks}
        try:
            if not self.snapshot_every and self._last >= 0:
                self._snapshot(self._last)
            self.flush()
            yield
        finally:
            self.sink, (self._blocks, self._groups) = None, kept
            for each, own in zip(pages, blocks, strict=True):
                each.blocks = own

    def state(self) -> dict[str, np.ndarray]:
        """Return the state after `flush`: stocks, the open page, pending events, series in memory."""
        out = {"stock": self._stock.copy(), "last": np.array(self._last)}
        out |= {f"page/{name}": as_plain(getattr(self, f"_{name}")[0]) for name in PAGES}
        for kind, groups in self._events.items():
            columns = self._together(kind, groups) if groups else {}
            out |= {f"{kind}/{name}": as_numbers(column) for name, column in columns.items()}
        if self.details is not None:
            out |= {f"details/{name}": column for name, column in self.details.state().items()}
        for kind, pages in self._pages.items():
            out |= {f"{kind}/{name}": array for name, array in pages.state().items()}
        return out | (joined(self._blocks, "series/") if self.sink is None else {})

    def load(self, state: dict[str, np.ndarray]) -> None:
        """Continue from a `state()`."""
        self._stock[:], self._last, self._at = state["stock"], int(state["last"]), 0
        for name in PAGES:
            array = getattr(self, f"_{name}")
            array[...] = 0
            array[0] = as_rows(state[f"page/{name}"], array.dtype)
        self._events = {kind: [] for kind in EVENTS}
        for kind, names in self.columns.items():
            if columns := under(state, f"{kind}/"):
                if "genome" in columns:
                    columns["genome"] = as_text(columns["genome"])
                self._events[kind] = [tuple(columns[name] for name in names)]
        if self.details is not None:
            self.details.load(under(state, "details/"))
        for kind, pages in self._pages.items():
            pages.load(under(state, f"{kind}/"))
        series = under(state, "series/")
        self._blocks = [series] if series else []

    def events(self, kind: str) -> dict[str, np.ndarray]:
        """Return the births or deaths in memory, in order.

        Parameters
        ----------
        kind : {"births", "deaths"}

        Returns
        -------
        dict of str to array
            One row per event. `species` is an index into `names`; `cause` is numbered from 1 as in
            `world.causes`; a recorded field is 0 if a species lacks it.

        Raises
        ------
        RuntimeError
            If the recorder was created without `keep_events=True`.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.record import Recorder
        >>> world = World.from_config("predator-prey", seed=1, record=False)
        >>> recorder = Recorder(world, keep_events=True)
        >>> deaths = world.run(5).recorder.events("deaths")
        >>> len(deaths["uid"]) > 0
        True
        """
        if self.sink is not None or not self.keeps:
            raise RuntimeError(
                "this recorder does not keep events in memory; create it with Recorder(world, keep_events=True)"
            )
        empty = [tuple(np.zeros(0, np.int64) for _ in self.columns[kind])]
        return self._together(kind, self._events[kind] or empty)

    def _together(self, kind: str, groups: list[tuple[np.ndarray, ...]]) -> dict[str, np.ndarray]:
        """Return the concatenated columns of groups of events."""
        columns = map(np.concatenate, zip(*groups, strict=True))
        return dict(zip(self.columns[kind], columns, strict=True))

    def _columns(self, n: int) -> dict[str, np.ndarray]:
        """Return copies of the first n ticks as flat columns, sorted by tick, then species."""
        s = len(self.names)
        out: dict[str, np.ndarray] = {
            "tick": self._tick[:n].ravel().copy(),
            "species": np.tile(np.arange(s, dtype=np.int8), n),
        }
        for array in (self._counts, self._means, self._ledger):
            out |= {name: array[name][:n].ravel() for name in array.dtype.names or ()}
        out |= self.intake.columns(n) | ({} if self.reports is None else self.reports.columns(n))
        return out | {
            f"died: {cause}": self._died[:n, :, i + 1].ravel() for i, cause in enumerate(self.world.causes)
        }

    def series(self) -> Any:
        """Return all ticks in memory.

        Returns
        -------
        pyarrow.Table
            One row for each tick and species.

        Examples
        --------
        >>> from ecs_eco import World
        >>> world = World.from_config("predator-prey", seed=1).run(3)
        >>> world.recorder.series().num_rows
        9
        """
        blocks = [*self._blocks, *([self._columns(self._at)] if self._at else [])]
        return as_table(blocks or [self._columns(0)], {"species": self.names})

    def since(self, tick: int) -> dict[str, np.ndarray]:
        """Return the series of the ticks after `tick` that are still in memory: columns [ticks, species]."""
        blocks = [*self._blocks, *([self._columns(self._at)] if self._at else [])]
        later = joined([b for b in blocks if b["tick"][-1] > tick] or [self._columns(0)], "")
        rows = later["tick"] > tick
        return {name: column[rows].reshape(-1, len(self.names)) for name, column in later.items()}

    def matter_series(self) -> Any:
        """Return the matter ledger of all ticks in memory.

        Returns
        -------
        pyarrow.Table
            One row for each tick, holder and substance; columns of `ecs_eco.record.matter.LEDGER` [mol].

        Raises
        ------
        RuntimeError
            If no body has substances.

        Examples
        --------
        >>> from ecs_eco import World
        >>> World.from_config("predator-prey", seed=1).recorder.matter_series()
        Traceback (most recent call last):
        RuntimeError: this world has no matter ledger: no body in it has substances
        """
        if self.matter is None:
            raise RuntimeError("this world has no matter ledger: no body in it has substances")
        return self.matter.series()

    def learning_series(self) -> Any:
        """Return the policy updates in memory.

        Returns
        -------
        pyarrow.Table
            One row per update.
        """
        return self.learning.series("learning")

    def action_series(self) -> Any:
        """Return how often each action was taken.

        Returns
        -------
        pyarrow.Table
            One row for each block of ticks, species and action, with the number of decisions.
        """
        return self.learning.series("actions")

    def words(self, kind: str) -> dict[str, list[str]]:
        """Return the strings that numbers in one kind of block stand for: column → strings."""
        if kind in MIGRATION and self.migrations is not None:
            return self.learning.words | self.migrations.words
        return self._pages[kind].words if kind in self._pages else self.learning.words


PAGES = ("counts", "means", "ledger", "died")
