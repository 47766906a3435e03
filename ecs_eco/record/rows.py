"""Records that kernels write: a row for each birth and each death, converted to columns on request, and sums
over the living organisms of each species."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.lib.recfunctions import structured_to_unstructured, unstructured_to_structured

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Metabolism, Nervous, Position
from ecs_eco.engine.addresses import column_at
from ecs_eco.record.ledger import COUNTS_ROW, FLOWS, LEDGER

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table

REFUSED = (COUNTS_ROW.names or ()).index("refused")
PLACE, ENERGY = 4, 7  # index of the first column of each kind in `noted_of`
ENDOWED, FLOW, BURNT, LOST, AFTER = (
    LEDGER.index(name) for name in ("endowed", next(iter(FLOWS)), "burnt", "lost", "stock_after")
)


class Lines(NamedTuple):
    """Rows of a `Rows` object for a kernel to fill, from index `first` on."""

    first: int
    longs: np.ndarray
    floats: np.ndarray
    small: np.ndarray


NOWHERE = Lines(0, np.empty((4, 0), np.uint64), np.empty((5, 0), np.float32), np.empty((2, 0), np.uint8))


class Rows:
    """Births or deaths: `longs` u64[4, …] are tick, uid and two more uids, `floats` f32[5, …] are position,
    energy and age, `small` u8[2, …] are species and cause."""

    def __init__(self) -> None:
        self.n = 0
        self.longs, self.floats = np.empty((4, 64), np.uint64), np.empty((5, 64), np.float32)
        self.small = np.empty((2, 64), np.uint8)

    def more(self, k: int) -> Lines:
        """Return the next k rows for writing."""
        first, self.n = self.n, self.n + k
        if self.n > self.small.shape[1]:
            self.longs, self.floats, self.small = (
                np.concatenate([a, np.empty((len(a), self.n), a.dtype)], 1)
                for a in (self.longs, self.floats, self.small)
            )
        return Lines(first, self.longs, self.floats, self.small)

    def taken(self, kind: str, last: int) -> list[tuple[np.ndarray, ...]]:
        """Return the columns of "births" or "deaths", as listed in EVENTS, and clear them; rows up to tick
        `last` come first, in a separate group."""
        ticks, groups = self.longs[0, : self.n].view(np.int64), []
        over = int(np.searchsorted(ticks, last, "right"))
        for some in (slice(0, over), slice(over, self.n)):
            if some.stop > some.start:
                tick, uid, one, two = self.longs[:, some].copy()
                *place, energy, age = self.floats[:, some].copy()
                species, cause = self.small[:, some].copy()
                end = (one, two, np.zeros(uid.size, "S1")) if kind == "births" else (cause, one, age)
                groups.append((tick.view(np.int64), species.view(np.int8), uid, *place, energy, *end))
        self.n = 0
        return groups


def note_births(
    table: Table,
    columns: np.ndarray,
    rows: np.ndarray,
    parents: np.ndarray,
    second: np.ndarray,
    tick: int,
    s: int,
    page: np.ndarray,
    into: Rows | None,
) -> None:
    """Add the energy of newborns in rows i64[k] to page f64[species, columns] of the ledger; record them in
    `into`. `columns` contains the addresses from the table's `noted_of`."""
    if Metabolism in table:
        page[s, ENDOWED] += np.add.reduce(table[Metabolism].energy.take(rows), dtype=np.float64)
    if into is not None:
        born(rows, parents, second, tick, s, table.high, columns, into.more(rows.size))


def note_deaths(
    table: Table,
    columns: np.ndarray,
    rows: np.ndarray,
    tick: int,
    dt: float,
    ticking: bool,
    s: int,
    page: np.ndarray,
    died: np.ndarray,
    into: Rows | None,
) -> None:
    """Add the losses of dying organisms in rows i64[k] to page f64[species, columns] of the ledger and, within a
    tick, their flows; between ticks, the page already contains these. Energy that they lack has not been burned.
    Count causes in `died` i32[256]; record deaths in `into`. `columns` are addresses from `noted_of`."""
    if Metabolism in table:
        m, left = table[Metabolism], table[Metabolism].energy.take(rows)
        flows = [column.take(rows) for column in (m.taken, m.burnt, m.given) if ticking]
        for i, column in (LOST, np.maximum(left, 0)), (BURNT, np.minimum(left, 0)), *enumerate(flows, FLOW):
            page[s, i] += np.add.reduce(column, dtype=np.float64)
    place = NOWHERE if into is None else into.more(rows.size)
    lose(rows, tick, dt, s, table.high, columns, died, place)


def noted_of(table: Table) -> tuple[np.ndarray | None, ...]:
    """Return the columns of a table that `born` and `lose` read."""
    columns: Any = table
    p, m = columns.get(Position), columns.get(Metabolism)
    place = (None,) * 3 if p is None else (p.x, p.y, p.z)
    return table.uid, table.born, table.cause, table.killer, *place, None if m is None else m.energy


@njit
def born(
    rows: np.ndarray,
    parents: np.ndarray,
    second: np.ndarray,
    tick: int,
    s: int,
    high: int,
    columns: np.ndarray,
    into: Lines,
) -> None:
    """Record each newborn. `columns` contains the addresses from `noted_of`."""
    for k in range(rows.size):
        i = into.first + k
        note(i, rows[k], tick, s, high, columns, into)
        into.longs[2, i], into.longs[3, i] = parents[k], second[k]


@njit
def lose(
    rows: np.ndarray,
    tick: int,
    dt: float,
    s: int,
    high: int,
    columns: np.ndarray,
    died: np.ndarray,
    into: Lines,
) -> None:
    """Count the causes of deaths, and record each death. `columns` contains the addresses from `noted_of`."""
    birth, cause = column_at(columns[1], np.int64, high), column_at(columns[2], np.uint8, high)
    killer = column_at(columns[3], np.uint64, high)
    for k in range(rows.size):
        i, row = into.first + k, rows[k]
        died[cause[row]] += 1
        if into.small.shape[1]:
            note(i, row, tick, s, high, columns, into)
            into.longs[2, i], into.small[1, i] = killer[row], cause[row]
            into.floats[4, i] = np.float32((tick - birth[row]) * dt)


@njit
def note(i, row, tick, s, high, columns, into):
    """Write the values common to births and deaths; they are zero if a table lacks the component."""
    _, longs, floats, small = into
    longs[0, i], longs[1, i], small[0, i] = tick, column_at(columns[0], np.uint64, high)[row], s
    for k in range(PLACE, ENERGY + 1):
        value = np.float32(0.0)
        if columns[k] != 0:
            value = column_at(columns[k], np.float32, high)[row]
        floats[k - PLACE, i] = value


def held_by(table: Table) -> tuple[np.ndarray | None, ...]:
    """Return the columns of a table that `add_up` reads: alive, energy, flows as in FLOWS, and happiness."""
    columns: Any = table
    m, nerves = columns.get(Metabolism), columns.get(Nervous)
    flows = (None,) * 4 if m is None else (m.energy, m.taken, m.burnt, m.given)
    return (table.alive, *flows, None if nerves is None else nerves.happiness)


@njit
def add_up(first, last, columns, high, living, stock, page, means, moods, gained, intake, flows):
    """Add up the stocks, flows and happiness of living organisms for each species from first to last − 1 that
    has energy. The results go into this tick's rows: page f64[species, …] of the ledger, which already
    contains the endowments, losses and flows of dead organisms; means f32[species, …] of energy and
    happiness; and moods f64[species], the sums of happiness. `columns` u64[species, …] contains the addresses
    from `held_by`, for the first `high` rows; living[species, 0] is the number of living organisms. `stock`
    f64[species] is updated from the energy before the tick to the energy after it. `intake` and `flows` are
    the sums over all ticks of the energy `gained` from foods and of the ledger."""
    for s in range(first, last):
        if columns[s, 1] != 0:
            add_up_energy(s, columns[s], high[s], living, stock, page, means, moods)
        for k in range(gained.shape[1]):
            intake[s, k] += gained[s, k]
        for k in range(page.shape[1]):
            flows[s, k] += page[s, k]


@njit
def add_up_energy(s, of, n, living, stock, page, means, moods):
    """Do the work of `add_up` for one species with energy."""
    alive, energy = column_at(of[0], np.bool_, n), column_at(of[1], np.float32, n)
    taken, burnt = column_at(of[2], np.float32, n), column_at(of[3], np.float32, n)
    given, happiness = column_at(of[4], np.float32, n), column_at(of[5], np.float32, n)
    feels = of[5] != 0
    e, t, b, g, h = 0.0, 0.0, 0.0, 0.0, 0.0
    for row in range(n):
        if alive[row]:
            e += energy[row]
            t += taken[row]
            b += burnt[row]
            g += given[row]
            if feels:
                h += happiness[row]
    page[s, 0] = stock[s]
    page[s, FLOW] += t
    page[s, FLOW + 1] += b
    page[s, FLOW + 2] += g
    page[s, AFTER] = stock[s] = e
    k = max(living[s, 0], 1)
    means[s, 0], means[s, 1], moods[s] = e / k, h / k, h


@njit
def mean_depth(alive, z, top):
    """Return the mean distance of living organisms below the top of the space [m], in float64."""
    total, n = 0.0, 0
    for row in range(alive.size):
        if alive[row]:
            total += top - z[row]
            n += 1
    return total / max(n, 1)


def stock_of(table: Table) -> float:
    """Return the total energy of a species, 0 if it has no metabolism."""
    return float(table[Metabolism].energy[table.rows()].sum(dtype=np.float64)) if Metabolism in table else 0.0


def as_plain(rows: np.ndarray) -> np.ndarray:
    """Return a copy; structured rows become an array whose last axis is the columns."""
    return structured_to_unstructured(rows, copy=True) if rows.dtype.names else rows.copy()


def as_rows(array: np.ndarray, dtype: np.dtype[Any]) -> np.ndarray:
    """Undo `as_plain`: return structured rows if `dtype` is structured, otherwise `array`."""
    names = dtype.names or ()
    if "refused" in names and array.shape[-1] < len(names):  # recorded by a version without this column
        array = np.insert(array, REFUSED, 0, axis=-1)
    return unstructured_to_structured(array, dtype) if names else array
