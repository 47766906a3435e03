"""Parents, births and deaths, noted while a watched world lives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.ecosystem import World
from ecs_eco.engine.table import Table

MOST = 500_000  # lives kept; beyond that the oldest quarter is dropped
LATER = 20_000  # pending births and deaths: entered one by one they would cost a large world some percent
FIELDS = {
    "uid": np.uint64,
    "parent": np.uint64,
    "second": np.uint64,
    "born": np.int64,
    "kind": np.int16,
    "generation": np.int32,
    "died": np.int64,
    "cause": np.uint8,
    "killer": np.uint64,
}


class PedigreeLog:
    """The lives of a world from now on, in columns by uid; those who live already have no known parents.

    It listens to births and deaths, changes nothing, and enters them only when it is queried, or when many
    are pending. Lives are in the order of uids, which are given in the order of births and never reused.
    """

    def __init__(self, world: World, most: int = MOST) -> None:
        self.world, self.most, self.n = world, most, 0
        self.names = list(world.tables)
        self._columns = {name: np.zeros(1024, kind) for name, kind in FIELDS.items()}
        # first uid, parents, second parents, tick, kind
        self._births: list[tuple[int, np.ndarray, np.ndarray, int, int]] = []
        self._deaths: list[tuple[np.ndarray, np.ndarray, np.ndarray, int]] = []  # uids, causes, killers, tick
        self._waiting = 0
        columns = [
            (t.uid[rows], t.born[rows], np.full(rows.size, i))
            for i, t in enumerate(world.tables.values())
            for rows in [t.rows()]
        ]
        uid, born, kind = (
            (np.concatenate(part) for part in zip(*columns, strict=True))
            if columns
            else (np.zeros(0, np.int64),) * 3
        )
        order = np.argsort(uid)
        nobody = np.zeros(uid.size, np.uint64)
        self._since, self._at = int(world.next_uid), uid.size  # the next uid, and its row
        self._add(
            uid[order].astype(np.int64),
            np.ones(uid.size, np.int64),
            born[order].astype(np.int64),
            kind[order],
            nobody,
            nobody,
        )
        none = np.zeros(0, np.int64)  # compiles the other kernel before anybody waits
        self._bury(none, none, none.astype(np.uint64), none.astype(np.uint8), none.astype(np.uint64))
        world.on_birth.append(self._was_born)
        world.on_death.append(self._has_died)

    def forget(self) -> None:
        """Listen no longer."""
        self.world.on_birth.remove(self._was_born)
        self.world.on_death.remove(self._has_died)

    def go_back(self, tick: int, next_uid: int) -> None:
        """Forget births and deaths from a tick on, before which `next_uid` had not been given."""
        self._settle()
        self.n = int(np.searchsorted(self._columns["uid"][: self.n], np.uint64(next_uid)))
        died = self._columns["died"][: self.n]
        died[died >= tick] = -1

    def parents(self, uid: int) -> list[int]:
        """Return the uids of its known parents, none, one or two."""
        row = self._row(uid)
        return (
            []
            if row is None
            else [int(p) for p in (self._columns["parent"][row], self._columns["second"][row]) if p]
        )

    def children(self, uid: int, most: int = 200) -> list[int]:
        """Return the uids of its children, in the order of birth; the last `most` of them."""
        self._settle()
        c, n = self._columns, self.n
        return [int(u) for u in c["uid"][:n][(c["parent"][:n] == uid) | (c["second"][:n] == uid)][-most:]]

    def born(self, uid: int) -> int | None:
        """Return the tick of its birth."""
        row = self._row(uid)
        return None if row is None else int(self._columns["born"][row])

    def generation(self, uid: int) -> int | None:
        """Return its generation: one more than that of its parents; 0 for those whose parents are not known."""
        row = self._row(uid)
        return None if row is None else int(self._columns["generation"][row])

    def species(self, uid: int) -> str | None:
        """Return the name of its table."""
        row = self._row(uid)
        return None if row is None else self.names[self._columns["kind"][row]]

    def died(self, uid: int) -> dict[str, Any] | None:
        """Return tick, cause and killer of its death; None while it lives."""
        row = self._row(uid)
        if row is None or self._columns["died"][row] < 0:
            return None
        c = self._columns
        killer = int(c["killer"][row])
        return {
            "tick": int(c["died"][row]),
            "cause": self.world.causes[c["cause"][row] - 1],
            "killer": killer or None,
        }

    def deaths(self, names: Sequence[str]) -> dict[str, dict[str, np.ndarray]]:
        """Return tick, age [s] and cause of each death of some species that is known, by species."""
        self._settle()
        c, out = {name: column[: self.n] for name, column in self._columns.items()}, {}
        words = np.array(["", *self.world.causes])
        for name in names:
            rows = np.flatnonzero((c["kind"] == self.names.index(name)) & (c["died"] >= 0))
            rows = rows[np.argsort(c["died"][rows], kind="stable")]
            if rows.size:
                age = (c["died"][rows] - c["born"][rows]) * self.world.dt
                out[name] = {"tick": c["died"][rows], "age": age, "cause": words[c["cause"][rows]]}
        return out

    def _row(self, uid: int) -> int | None:
        self._settle()
        uids = self._columns["uid"][: self.n]
        row = int(np.searchsorted(uids, np.uint64(uid)))
        return row if row < self.n and uids[row] == uid else None

    def _was_born(self, table: Table, rows: np.ndarray, parents: np.ndarray, second: np.ndarray) -> None:
        self._births.append(
            (int(table.uid[rows[0]]), parents, second, self.world.tick, self.names.index(table.name))
        )
        self._wait(rows.size)

    def _has_died(self, table: Table, rows: np.ndarray) -> None:
        self._deaths.append((table.uid[rows], table.cause[rows], table.killer[rows], self.world.tick))
        self._wait(rows.size)

    def _wait(self, k: int) -> None:
        self._waiting += k + 50  # a call costs memory besides its arrays
        if self._waiting > LATER:
            self._settle()

    def _settle(self) -> None:
        """Enter all pending births, then deaths: nothing dies before it is born."""
        births, deaths, self._births, self._deaths, self._waiting = self._births, self._deaths, [], [], 0
        if births:
            first, size, tick, kind = np.array([(b[0], b[1].size, b[3], b[4]) for b in births], np.int64).T
            self._add(
                first,
                size,
                tick,
                kind,
                np.concatenate([b[1] for b in births]),
                np.concatenate([b[2] for b in births]),
            )
        if deaths:
            size, tick = np.array([(death[0].size, death[3]) for death in deaths], np.int64).T
            self._bury(size, tick, *(np.concatenate([death[i] for death in deaths]) for i in (0, 1, 2)))

    def _bury(
        self, size: np.ndarray, tick: np.ndarray, uid: np.ndarray, cause: np.ndarray, killer: np.ndarray
    ) -> None:
        """Enter deaths: number and tick of each batch i64[k]; uid, cause and killer of each death."""
        c = self._columns
        enter_deaths(
            size,
            tick,
            uid,
            cause,
            killer,
            self.n,
            self._since,
            self._at,
            c["uid"],
            c["died"],
            c["cause"],
            c["killer"],
        )

    def _add(
        self,
        first: np.ndarray,
        size: np.ndarray,
        tick: np.ndarray,
        kind: np.ndarray,
        parent: np.ndarray,
        second: np.ndarray,
    ) -> None:
        """Enter litters: the first uid, number, tick and kind of each i64[k]; both parents of each life."""
        self._reserve(parent.size)
        enter_births(
            first, size, tick, kind, parent, second, self.n, self._since, self._at, *self._columns.values()
        )
        self.n += parent.size

    def _reserve(self, k: int) -> None:
        forgotten = max(self.n // 4, min(self.n, self.n + k - self.most)) if self.n + k > self.most else 0
        self.n, self._at = self.n - forgotten, self._at - forgotten
        room = max(self._columns["uid"].size, self.n + k)
        for name, column in self._columns.items():
            kept = column[forgotten : forgotten + self.n]
            if room > column.size:
                self._columns[name] = np.zeros(2 * room, column.dtype)
            if forgotten or room > column.size:
                self._columns[name][: self.n] = kept


@njit
def row_of(uid, uids, n, since, at):
    """Return the row of a uid among `n` lives, −1 where it is unknown; those from `since` on, which begin at
    row `at`, have no gaps."""
    if uid >= np.uint64(since):
        row = np.int64(uid) - since + at
    else:
        row = np.searchsorted(uids[: max(at, 0)], uid)
    return row if 0 <= row < n and uids[row] == uid else -1


@njit
def enter_births(
    first,
    size,
    tick,
    kind,
    parent,
    second,
    n,
    since,
    at,
    uids,
    parents,
    seconds,
    born,
    kinds,
    generation,
    died,
    cause,
    killer,
):
    """Write litters behind the `n` lives that are known; parents are known before their young."""
    k = 0
    for litter in range(first.size):
        for i in range(size[litter]):
            row = n + k
            uids[row] = np.uint64(first[litter] + i)
            parents[row], seconds[row] = parent[k], second[k]
            born[row], kinds[row] = tick[litter], kind[litter]
            died[row], cause[row], killer[row] = -1, 0, 0
            deepest = 0
            for above in (parent[k], second[k]):
                if above:
                    other = row_of(above, uids, row, since, at)
                    if other >= 0:
                        deepest = max(deepest, generation[other] + 1)
            generation[row] = deepest
            k += 1


@njit
def enter_deaths(size, tick, uid, cause, killer, n, since, at, uids, died, causes, killers):
    """Write when and of what those died who are known."""
    k = 0
    for batch in range(size.size):
        for _ in range(size[batch]):
            row = row_of(uid[k], uids, n, since, at)
            if row >= 0:
                died[row], causes[row], killers[row] = tick[batch], cause[k], killer[k]
            k += 1
