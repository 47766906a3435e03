"""Rollout of a shared policy in bands: each process stores its own transitions, and all processes learn from
all of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.engine.uids import matched
from ecs_eco.learning.rollout import Rollout, _lives

if TYPE_CHECKING:
    from numpy.typing import DTypeLike

    from ecs_eco.bands.exchange import Wire
    from ecs_eco.engine.table import Table

DEAD = np.uint64(1 << 63)  # lives that have ended are numbered from here; all uids are smaller


class BandRollout(Rollout):
    """The transitions of organisms in a band, each with a uid and its index among all transitions.

    An open record moves with its organism, so that the reward can still be added. `advantages` gathers all
    records in every process, in the same order as a single process would; the processes then share the work
    of learning from them."""

    table: Table
    wire: Wire
    total = 0  # number of records in all processes
    stored = 0  # records stored by this process in this tick

    @classmethod
    def of(cls, table: Table, wire: Wire, holds: Callable[[np.ndarray], np.ndarray]) -> BandRollout:
        """Replace the rollout of a species that learns a shared policy. Keep the open records of organisms in
        rows for which `holds(rows)` is true; process 0 also keeps all closed records."""
        learner = table.species.nerves.learner
        old: Rollout = learner.rollout
        out = cls.like(old)
        out.table, out.wire = table, wire
        out._take_over(old, holds)
        learner.rollout = out
        return out

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._lives = np.empty(0, np.uint64)  # life of each record: a uid, or a number from DEAD upward
        self._places = np.empty(0, np.int64)  # index among all records; −1 if the record has moved away

    def _columns(self) -> tuple[np.ndarray, ...]:
        return (*super()._columns(), self._lives, self._places)

    def _hold(self, columns: Iterable[np.ndarray]) -> None:
        *known, self._lives, self._places = columns
        super()._hold(known)

    def _take_over(self, old: Rollout, holds: Callable[[np.ndarray], np.ndarray]) -> None:
        row = old.steps["row"]
        order, follows = _lives(row, old.ended)
        lives = np.empty(old.n, np.uint64)
        lives[order] = DEAD + np.cumsum(np.append(True, ~follows)[: old.n]).astype(np.uint64)
        owners = np.flatnonzero(old.last >= 0)  # rows with an open record
        opened = old.last[owners]
        for life, uid in zip(lives[opened], self.table.uid[owners], strict=True):
            lives[lives == life] = uid
        mine = np.full(old.n, self.wire.rank == 0)
        mine[opened] = holds(owners)
        self._hold([*(column[: old.n][mine] for column in old._columns()), lives[mine], np.flatnonzero(mine)])
        self.n, self.ticks, self.total = int(mine.sum()), old.ticks, old.n
        self.last = np.full(self.table.capacity, -1)
        here = np.flatnonzero(mine[opened])
        self.last[owners[here]] = (np.cumsum(mine) - 1)[opened[here]]

    @property
    def learns(self) -> bool:
        """Whether the species is learning now."""
        return bool(self.table.species.nerves.learning)

    def store(self, rows: np.ndarray, *arrays: Any) -> None:
        """Append the transitions of one tick; `close` assigns their indices once the counts of all processes
        are known."""
        ticks, start = self.ticks, self.n
        super().store(rows, *arrays)
        self.ticks, self.stored = ticks, len(rows)
        self._lives[start : self.n], self._places[start : self.n] = self.table.uid[rows], -1

    def close(self, counts: np.ndarray) -> None:
        """End a tick in which process k has stored counts[k] records."""
        first = self.total + int(counts[: self.wire.rank].sum())
        if self.stored:
            self._places[self.n - self.stored : self.n] = first + np.arange(self.stored)
        self.total += int(counts.sum())
        self.ticks += int(counts.sum() > 0)
        self.stored = 0

    # --- organisms that move to another process -------------------------------------------------------------

    def take(self, rows: np.ndarray) -> np.ndarray:
        """Remove the open records of rows i64[k] and return them as bytes u8[…]."""
        self._cover(rows)
        at = self.last[rows]
        of = np.flatnonzero(at >= 0)
        at = at[of]
        pieces = [np.array([of.size]), of, *(column[at] for column in self._columns())]
        self._places[at], self.last[rows] = -1, -1
        return np.concatenate([np.ascontiguousarray(p).reshape(-1).view(np.uint8) for p in pieces])

    def give(self, rows: np.ndarray, data: np.ndarray) -> np.ndarray:
        """Add the open records of organisms that arrived in rows i64[k]; return the remaining bytes."""
        n, at = int(data[:8].copy().view(np.int64)[0]), 8

        def read(dtype: DTypeLike, inner: tuple[int, ...] = ()) -> np.ndarray:
            nonlocal at
            size = n * np.dtype(dtype).itemsize * int(np.prod(inner))
            at += size
            return data[at - size : at].copy().view(dtype).reshape(n, *inner)

        of, start, stop = read(np.int64), self.n, self.n + n
        if stop > len(self._ended):
            self._grow(stop)
        self._cover(rows)
        for column in self._columns():
            column[start:stop] = read(column.dtype, column.shape[1:])
        self._steps["row"][start:stop] = rows[of]
        self.last[rows[of]] = np.arange(start, stop)
        self.n = stop
        return data[at:]

    # --- learning -------------------------------------------------------------------------------------------

    def advantages(self, rows: np.ndarray, values: np.ndarray, gae_lambda: float) -> None:
        """Gather the records of all processes and compute their advantages. `values` f32[n] are the expected
        returns of this process's living rows."""
        uid, later = self.wire.everyone(self.table.uid[rows], np.asarray(values, np.float32))
        known, columns = self.gathered()
        self._hold(columns)
        self.n, self.last = len(self._ended), last_of(self._steps["row"], self._ended, known.size)
        at, acted = matched(known, uid)
        super().advantages(at[acted], later[acted], gae_lambda)

    def gathered(self) -> tuple[np.ndarray, list[np.ndarray]]:
        """Return the lives u64[k] in the records of all processes, and the columns of these records in the
        same order as in a single process. A record's row is an index into the lives."""
        kept = np.flatnonzero(self._places[: self.n] >= 0)
        columns = self.wire.everyone(*(column[: self.n][kept] for column in self._columns()))
        order = np.argsort(columns[-1])
        sorted_ = [column[order] for column in columns]
        known, row = np.unique(sorted_[-2], return_inverse=True)
        sorted_[4]["row"] = row
        return known, sorted_

    def clear(self) -> None:
        """Remove all transitions."""
        self._hold([column[:0].copy() for column in self._columns()])
        self.last = np.empty(0, np.int64)
        self.n = self.ticks = self.total = self.stored = 0


def last_of(row: np.ndarray, ended: np.ndarray, n: int) -> np.ndarray:
    """Return the index of the open record in each of n lives, or −1 if the life has ended: i64[n]."""
    last = np.full(n, -1)
    np.maximum.at(last, row, np.arange(len(row)))
    acts = np.flatnonzero(last >= 0)
    last[acts[ended[last[acts]]]] = -1
    return last
