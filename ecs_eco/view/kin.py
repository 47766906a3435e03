"""Who is whose child, when each was born and how each died: noted while a watched world lives."""

from __future__ import annotations

from typing import Any

import numpy as np

MOST = 500_000  # lives that are remembered; beyond that the oldest quarter is forgotten
FIELDS = {"uid": np.uint64, "parent": np.uint64, "second": np.uint64, "born": np.int64, "kind": np.int16, "generation": np.int32,
          "died": np.int64, "cause": np.uint8, "killer": np.uint64}  # fmt: skip


class Kin:
    """The lives of a world from now on, in columns by uid; those who live already have no known parents.

    It listens to births and deaths; it changes nothing. Lives are added in the order of uids, which are never reused.
    """

    def __init__(self, world: Any, most: int = MOST) -> None:
        self.world, self.most, self.n = world, most, 0
        self.names = list(world.tables)
        self._columns = {name: np.zeros(1024, kind) for name, kind in FIELDS.items()}
        found = [(t.uid[rows], t.born[rows], np.full(rows.size, i)) for i, t in enumerate(world.tables.values()) for rows in [t.rows()]]
        uid, born, kind = (np.concatenate(part) for part in zip(*found, strict=True)) if found else (np.zeros(0, np.int64),) * 3
        order = np.argsort(uid)
        nobody = np.zeros(uid.size, np.uint64)
        self._add(uid[order], nobody, nobody, born[order], kind[order])
        world.on_birth.append(self._was_born)
        world.on_death.append(self._has_died)

    def forget(self) -> None:
        """Listen no longer."""
        self.world.on_birth.remove(self._was_born)
        self.world.on_death.remove(self._has_died)

    def parents(self, uid: int) -> list[int]:
        """Return the uids of its known parents, none, one or two."""
        row = self._row(uid)
        return [] if row is None else [int(p) for p in (self._columns["parent"][row], self._columns["second"][row]) if p]

    def children(self, uid: int, most: int = 200) -> list[int]:
        """Return the uids of its children, in the order of birth; the last `most` of them."""
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
        return {"tick": int(c["died"][row]), "cause": self.world.causes[c["cause"][row] - 1], "killer": killer or None}

    def _row(self, uid: int) -> int | None:
        uids = self._columns["uid"][: self.n]
        row = int(np.searchsorted(uids, np.uint64(uid)))
        return row if row < self.n and uids[row] == uid else None

    def _rows(self, uid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the rows of these uids, and which of them are known."""
        uids = self._columns["uid"][: self.n]
        rows = np.minimum(np.searchsorted(uids, uid), max(self.n - 1, 0))
        return rows, uids[rows] == uid if self.n else np.zeros(uid.size, np.bool_)

    def _was_born(self, table: Any, rows: np.ndarray, parents: np.ndarray, second: np.ndarray) -> None:
        self._add(table.uid[rows], parents, second, table.born[rows], np.full(rows.size, self.names.index(table.name)))

    def _has_died(self, table: Any, rows: np.ndarray) -> None:
        at, known = self._rows(table.uid[rows])
        at, rows = at[known], rows[known]
        self._columns["died"][at] = self.world.tick
        self._columns["cause"][at] = table.cause[rows]
        self._columns["killer"][at] = table.killer[rows]

    def _add(self, uid: np.ndarray, parent: np.ndarray, second: np.ndarray, born: np.ndarray, kind: np.ndarray) -> None:
        generation = np.zeros(uid.size, np.int32)
        for who in (parent, second):
            if self.n and who.any():
                at, known = self._rows(who)
                generation = np.maximum(generation, np.where(known, self._columns["generation"][at] + 1, 0))
        self._reserve(uid.size)
        new = slice(self.n, self.n + uid.size)
        for name, values in zip(FIELDS, (uid, parent, second, born, kind, generation, -1, 0, 0), strict=True):
            self._columns[name][new] = values
        self.n += uid.size

    def _reserve(self, k: int) -> None:
        forgotten = self.n // 4 if self.n + k > self.most else 0
        self.n -= forgotten
        room = max(self._columns["uid"].size, self.n + k)
        room = room if room == self._columns["uid"].size else 2 * room
        for name, column in self._columns.items():
            if forgotten or room != column.size:
                grown = np.zeros(room, column.dtype)
                grown[: self.n] = column[forgotten : forgotten + self.n]
                self._columns[name] = grown
