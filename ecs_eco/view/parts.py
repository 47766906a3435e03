"""The rows of one kind in a recording, read by block and column, from parts on disk or from memory."""

from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa

from ecs_eco.analysis.runs import parts
from ecs_eco.engine.errors import RecordingError
from ecs_eco.record.parquet import open_part, read_group, read_metadata, to_codes

BUDGET = 192 * 2**20  # [bytes] maximum size of cached columns
Columns = dict[str, np.ndarray]


class Group(NamedTuple):
    """A row group of a part or a block in memory, with its inclusive tick and uid ranges."""

    path: Path | None
    number: int
    rows: int
    ticks: tuple[int, int]
    uids: tuple[int, int] | None  # None if there is no uid column
    names: tuple[str, ...]


class Cache:
    """A cache of columns and open files; the oldest columns are dropped when it exceeds its budget [bytes]."""

    def __init__(self, budget: int = BUDGET) -> None:
        self.budget, self.size = budget, 0
        self.columns: OrderedDict[tuple[Path, int, str], np.ndarray] = OrderedDict()
        self.file = lru_cache(4)(open_part)  # open parts, with verified seals

    def put(self, key: tuple[Path, int, str], column: np.ndarray) -> None:
        """Add a column to the cache, or mark it as used."""
        if key not in self.columns:
            self.size += column.nbytes
        self.columns[key] = column
        self.columns.move_to_end(key)
        while self.size > self.budget and len(self.columns) > 1:
            self.size -= self.columns.popitem(last=False)[1].nbytes


class Blocks:
    """All rows of one kind, such as "births", in groups read by column: `Parts` on disk, `Kept` in memory."""

    groups: list[Group]

    def read(self, group: Group, names: Sequence[str]) -> Columns:
        """Return columns of one group, with zeros for missing columns."""
        raise NotImplementedError

    @property
    def rows(self) -> int:
        """Total number of rows."""
        return sum(group.rows for group in self.groups)

    def ticks(self) -> tuple[int, int] | None:
        """Return the first and last tick, or None if there are no rows."""
        spans = [group.ticks for group in self.groups if group.rows]
        return (min(first for first, _ in spans), max(last for _, last in spans)) if spans else None

    def between(self, first: int, last: int, names: Sequence[str], uid: int | None = None) -> Columns:
        """Return columns of the rows (of one organism) from tick `first` to tick `last`, in recorded order."""
        blocks: list[Columns] = []
        for group in self.groups:
            if group.rows and group.ticks[0] <= last and group.ticks[1] >= first and _has(group, uid):
                keys = self.read(group, ("tick",) if uid is None else ("tick", "uid"))
                chosen = (keys["tick"] >= first) & (keys["tick"] <= last)
                chosen = chosen if uid is None else chosen & (keys["uid"] == uid)
                if uid is None or chosen.any():
                    columns = self.read(group, ("tick", *names))
                    blocks.append({name: column[chosen] for name, column in columns.items()})
        if not blocks:
            return {
                name: np.zeros(0, np.float32 if name in FLOATS else np.int64) for name in ("tick", *names)
            }
        return {name: np.concatenate([columns[name] for columns in blocks]) for name in ("tick", *names)}

    def each(self, names: Sequence[str]) -> Iterator[Columns]:
        """Yield these columns, one row group at a time."""
        for group in self.groups:
            yield self.read(group, names)

    def find(self, uid: int, names: Sequence[str], first: int = 0) -> dict[str, Any] | None:
        """Return an organism's first row at or after a tick as a dict, or None if there is none."""
        for group in self.groups:
            if group.rows and group.ticks[1] >= first and _has(group, uid):
                at = np.flatnonzero(self.read(group, ("uid",))["uid"] == uid)
                if at.size:
                    return {name: column[at[0]] for name, column in self.read(group, names).items()}
        return None


def _has(group: Group, uid: int | None) -> bool:
    """Return whether a group may contain this organism (None: any organism)."""
    return uid is None or group.uids is None or group.uids[0] <= uid <= group.uids[1]


class Kept(Blocks):
    """Rows in memory, in groups of at least `size` rows; beyond `most` rows, the oldest group is dropped."""

    def __init__(self, size: int, most: int) -> None:
        self.size, self.most = size, most
        self.groups = []
        self._columns: dict[int, Columns] = {}  # by group number
        self._number = 0

    def add(self, columns: Columns) -> None:
        """Add one or more rows, all later than the existing rows."""
        if self.groups and self.groups[-1].rows < self.size:
            last = self._columns.pop(self.groups.pop().number)
            columns = {name: np.concatenate([last[name], column]) for name, column in columns.items()}
        ticks, uids = ((int(columns[name].min()), int(columns[name].max())) for name in ("tick", "uid"))
        self._number += 1
        self._columns[self._number] = columns
        self.groups.append(Group(None, self._number, columns["uid"].size, ticks, uids, tuple(columns)))
        while self.rows > self.most and len(self.groups) > 1:
            del self._columns[self.groups.pop(0).number]

    def keep(self, name: str, below: int) -> None:
        """Keep only rows whose value in a column is less than `below`."""
        held, self._columns, self.groups = list(self._columns.values()), {}, []
        for columns in held:
            rows = np.flatnonzero(columns[name] < below)
            if rows.size:
                self.add({n: column[rows] for n, column in columns.items()})

    def read(self, group: Group, names: Sequence[str]) -> Columns:
        columns = self._columns[group.number]
        return {name: columns.get(name, np.zeros(group.rows, np.uint64)) for name in names}


class Parts(Blocks):
    """All parts of one kind, such as "births"; `words` lists the words of each text column by number."""

    def __init__(
        self, run: Path, kind: str, words: Mapping[str, Sequence[str]], cache: Cache, sealed: bool
    ) -> None:
        self.words, self.cache, self.sealed = words, cache, sealed
        self.groups = [group for path in parts(run, kind) for group in _groups(path)]

    def read(self, group: Group, names: Sequence[str]) -> Columns:
        cache, path = self.cache, group.path
        assert path is not None
        keys = {name: (path, group.number, name) for name in names if name in group.names}
        known = {name: cache.columns[key] for name, key in keys.items() if key in cache.columns}
        if missing := [name for name in keys if name not in known]:
            table = read_group(path, cache.file(path, self.sealed), group.number, missing)
            known |= {name: self._plain(name, table[name]) for name in missing}
        for name, key in keys.items():
            cache.put(key, known[name])
        return {name: known[name] if name in known else np.zeros(group.rows, np.uint64) for name in names}

    def _plain(self, name: str, column: pa.ChunkedArray) -> np.ndarray:
        if name in self.words:
            words, codes = to_codes(column)
            known = {word: number for number, word in enumerate(self.words[name])}
            return np.array([known.get(word, -1) for word in words], np.int16)[codes]
        if pa.types.is_dictionary(column.type):
            column = column.cast(column.type.value_type)
        return column.to_numpy()


FLOATS = ("x", "y", "z", "heading", "energy", "happiness", "reward", "age")


def _groups(path: Path) -> Iterator[Group]:
    """Yield the row groups of a part; raise RecordingError if its footer cannot be read."""
    meta = read_metadata(path)
    names = tuple(meta.schema.to_arrow_schema().names)
    for number in range(meta.num_row_groups):
        group = meta.row_group(number)
        spans = {}
        for i in range(group.num_columns):
            column = group.column(i)
            if column.path_in_schema in ("tick", "uid"):
                s = column.statistics
                spans[column.path_in_schema] = (
                    (int(s.min), int(s.max)) if s is not None and s.has_min_max else (0, 2**63 - 1)
                )
        if "tick" not in spans:
            raise RecordingError(f"{path}: has no `tick` column")
        yield Group(path, number, group.num_rows, spans["tick"], spans.get("uid"), names)
