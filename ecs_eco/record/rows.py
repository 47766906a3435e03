"""What kernels note for a record: births and deaths, a row each, which become columns when these are asked
for, and sums over the living of one species."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Metabolism, Position
from ecs_eco.engine.jit import njit
from ecs_eco.record.ledger import FLOWS, LEDGER

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table

NOTHING = np.zeros(0, np.float32)
HERE, HELD = (NOTHING,) * 3, (NOTHING,) * 4  # of tables without Position, without Metabolism
SUMMED = 128  # so many numbers numpy adds up in one piece
ENDOWED, FLOW, LOST, AFTER = (LEDGER.index(name) for name in ("endowed", next(iter(FLOWS)), "lost",
                                                               "stock_after"))
NOWHERE = 0, np.empty((4, 0), np.uint64), np.empty((5, 0), np.float32), np.empty((2, 0), np.uint8)


class Rows:
    """Births or deaths: longs u64[4, …] tick, uid and two more uids, floats f32[5, …] place, energy and age,
    small u8[2, …] species and cause."""

    def __init__(self) -> None:
        self.n = 0
        self.longs, self.floats, self.small = (np.empty((4, 64), np.uint64), np.empty((5, 64), np.float32),
                                               np.empty((2, 64), np.uint8))

    def more(self, k: int) -> tuple[int, np.ndarray, np.ndarray, np.ndarray]:
        """Return where the next k go, and the arrays that they go to."""
        first, self.n = self.n, self.n + k
        if self.n > self.small.shape[1]:
            self.longs, self.floats, self.small = (
                np.concatenate([a, np.empty((len(a), self.n), a.dtype)], 1)
                for a in (self.longs, self.floats, self.small))
        return first, self.longs, self.floats, self.small

    def taken(self, kind: str, last: int) -> list[tuple[np.ndarray, ...]]:
        """Return the columns of "births" or "deaths", as EVENTS names them, those up to tick `last` first;
        forget them."""
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


def note_births(table: Table, rows: np.ndarray, parents: np.ndarray, second: np.ndarray, tick: int, s: int,
                page: np.ndarray, into: Rows | None) -> None:
    """Add what newborn in rows i64[k] are endowed with to page f64[species, columns] of the ledger; note them
    `into` rows."""
    columns: Any = table.columns
    p, m = columns.get(Position), columns.get(Metabolism)
    here = HERE if p is None else (p.x, p.y, p.z)
    energy = NOTHING if m is None else m.energy
    if m is not None and rows.size > SUMMED:
        page[s, ENDOWED] += np.add.reduce(energy[rows], dtype=np.float64)
    born(rows, parents, second, tick, s, table.uid, *here, energy, page,
         *(NOWHERE if into is None else into.more(rows.size)))


def note_deaths(table: Table, rows: np.ndarray, tick: int, dt: float, ticking: bool, s: int, page: np.ndarray,
                died: np.ndarray, into: Rows | None) -> None:
    """Add what the dying in rows i64[k] lose to page f64[species, columns] of the ledger, and within a tick
    their flows: between ticks these are there already. Count their causes in `died` i32[256]; note them
    `into` rows."""
    columns: Any = table.columns
    p, m = columns.get(Position), columns.get(Metabolism)
    here = HERE if p is None else (p.x, p.y, p.z)
    held = HELD if m is None else (m.taken, m.burnt, m.given, m.energy)  # flows as in FLOWS
    first = 0 if ticking else len(FLOWS)
    if m is not None and rows.size > SUMMED:
        for i, column in enumerate(held[first:], FLOW + first):
            page[s, i] += np.add.reduce(column[rows], dtype=np.float64)
    lose(rows, tick, dt, s, first, table.uid, table.born, table.cause, table.killer, *here, *held, page, died,
         *(NOWHERE if into is None else into.more(rows.size)))


@njit
def born(rows, parents, second, tick, s, uid, x, y, z, energy, page, first, longs, floats, small):
    """Add up what newborn are endowed with, and note each."""
    if energy.size and rows.size <= SUMMED:
        page[s, ENDOWED] += total(energy, rows)
    for k in range(rows.size if small.shape[1] else 0):
        i, row = first + k, rows[k]
        note(i, row, tick, s, uid, x, y, z, energy, longs, floats, small)
        longs[2, i], longs[3, i] = parents[k], second[k]


@njit
def lose(rows, tick, dt, s, first_flow, uid, birth, cause, killer, x, y, z, taken, burnt, given, energy, page,
         died, first, longs, floats, small):
    """Add up what the dying lose, count their causes, and note each."""
    if energy.size and rows.size <= SUMMED:
        if first_flow == 0:
            page[s, FLOW] += total(taken, rows)
            page[s, FLOW + 1] += total(burnt, rows)
            page[s, FLOW + 2] += total(given, rows)
        page[s, LOST] += total(energy, rows)
    for k in range(rows.size):
        i, row = first + k, rows[k]
        died[cause[row]] += 1
        if small.shape[1]:
            note(i, row, tick, s, uid, x, y, z, energy, longs, floats, small)
            longs[2, i], small[1, i] = killer[row], cause[row]
            floats[4, i] = np.float32((tick - birth[row]) * dt)


@njit
def note(i, row, tick, s, uid, x, y, z, energy, longs, floats, small):
    """Write what births and deaths have in common: zeros where a table lacks the component."""
    zero = np.float32(0.0)
    longs[0, i], longs[1, i], small[0, i] = tick, uid[row], s
    floats[0, i], floats[1, i], floats[2, i] = zero, zero, zero
    if x.size:
        floats[0, i], floats[1, i], floats[2, i] = x[row], y[row], z[row]
    floats[3, i] = energy[row] if energy.size else zero


@njit
def total(values, rows):
    """Return the sum of the values of at most SUMMED rows, in float64, in the order in which numpy adds."""
    n, sum_ = rows.size, 0.0
    if n < 8:
        for k in range(n):
            sum_ += values[rows[k]]
        return sum_
    part, end = np.zeros(8), n - n % 8
    for k in range(end):
        part[k % 8] += values[rows[k]]
    sum_ = (part[0] + part[1]) + (part[2] + part[3])
    sum_ += (part[4] + part[5]) + (part[6] + part[7])
    for k in range(end, n):
        sum_ += values[rows[k]]
    return sum_


@njit
def add_up(alive, n, energy, taken, burnt, given, happiness, s, stock, page, means, moods):
    """Write what the n living of species s hold and feel to its row of this tick: page f64[species, …] of the
    ledger, where what was endowed, lost, and flowed in the dead stands already, means f32[species, …] of
    energy and happiness, and moods f64[species], the sums of happiness. `stock` f64[species] is what they
    held before, then what they hold."""
    e, t, b, g, h = 0.0, 0.0, 0.0, 0.0, 0.0
    feels = happiness.size > 0
    for row in range(alive.size):
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
    n = max(n, 1)
    means[s, 0], means[s, 1], moods[s] = e / n, h / n, h


@njit
def mean_depth(alive, z, top):
    """Return the mean distance of the living below the top of the space [m], in float64."""
    total, n = 0.0, 0
    for row in range(alive.size):
        if alive[row]:
            total += top - z[row]
            n += 1
    return total / max(n, 1)
