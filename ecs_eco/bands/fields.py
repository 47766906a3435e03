"""Smells in bands: each process updates its own rows of a field and keeps copies of the adjacent rows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.bands.edges import Edges, beyond
from ecs_eco.space.field import Field, _diffuse

if TYPE_CHECKING:
    from ecs_eco.bands.exchange import Wire


class BandField:
    """The rows of a field whose centers lie in a band.

    `halo` is the number of adjacent rows that `trade` copies from other processes.
    """

    def __init__(self, field: Field, edges: Edges, rank: int, halo: int) -> None:
        self.field, self.edges, self.rank, self.halo = field, edges, rank, halo
        field.band = self
        self._of: tuple[Any, np.ndarray] = (None, np.zeros(0, np.int64))  # edges, owners
        self._traded: dict[tuple[int, int], np.ndarray] = {}

    def owners(self) -> np.ndarray:
        """Return the process that owns each row of the field: i64[ny]."""
        if self._of[0] is not self.edges.rows:
            ny = self.field.shape[1]
            middle = (np.arange(ny) + 0.5) * self.field.space.size[1] / ny
            self._of = self.edges.rows, self.edges.owner_of(middle.astype(np.float32))
            self._traded = {}
        return self._of[1]

    def span(self, rank: int) -> tuple[int, int]:
        """Return a process's first row and the row after its last."""
        first, last = np.searchsorted(self.owners(), [rank, rank + 1])
        return int(first), int(last)

    def rows_for(self, reader: int, owner: int) -> np.ndarray:
        """Return a mask bool[ny] of the rows of process `owner` that process `reader` needs."""
        owners = self.owners()
        if (reader, owner) not in self._traded:
            near = beyond(*self.span(reader), self.field.shape[1], self.halo, self.field.space.torus)
            self._traded[reader, owner] = near & (owners == owner)
        return self._traded[reader, owner]

    def pass_time(self, dt: float, *emitted: Any) -> None:
        """Add sources, spread and decay in this band's rows, bit for bit as `Field.pass_time` does."""
        field, torus = self.field, self.field.space.torus
        if emitted:
            field.emit(*emitted)
        steps, a, left, arrives = field._plan(dt)
        (first, last), ny = self.span(self.rank), field.shape[1]
        if last - first + 2 * steps >= ny:
            rows = np.arange(ny)
        elif torus:
            rows = np.arange(first - steps, last + steps) % ny
        else:
            rows = np.arange(max(first - steps, 0), min(last + steps, ny))
        now = left * field.value[:, rows] + arrives * field.source[:, rows]
        field.source.fill(0)
        new = np.empty_like(now)
        for _ in range(steps):
            _diffuse(now, new, a, torus)
            now, new = new, now
        mine = (rows >= first) & (rows < last)
        field.value[:, first:last] = now[:, mine]


def halo_of(field: Field, dt: float, noses: float) -> int:
    """Return how many field rows beyond a band are needed if noses are at most `noses` [m] from body centers."""
    return max(field._plan(dt)[0], 2 + math.ceil(noses * float(field.inverse[1])))


def trade(fields: Sequence[BandField], wire: Wire) -> None:
    """Send each process the rows that it reads from other bands."""
    parts, mine = {}, wire.rank
    for rank in range(wire.size) if fields else ():
        read = [f.rows_for(rank, mine) for f in fields]
        if rank != mine and any(r.any() for r in read):
            parts[rank] = np.concatenate(
                [
                    np.ascontiguousarray(f.field.value[:, r]).reshape(-1).view(np.uint8)
                    for f, r in zip(fields, read, strict=True)
                ]
            )
    for rank, data in (wire.swap(parts) if fields else {}).items():
        at = 0
        for f in fields:
            rows = f.rows_for(mine, rank)
            value = f.field.value
            shape = len(value), int(rows.sum()), value.shape[2]
            size = value.itemsize * int(np.prod(shape))
            value[:, rows] = data[at : at + size].view(value.dtype).reshape(shape)
            at += size


def complete(fields: Sequence[BandField], wire: Wire) -> None:
    """Send all rows of all fields to every process, before edges move or when the whole world is needed."""
    for f in fields:
        first, last = f.span(wire.rank)
        (rows,) = wire.everyone(np.ascontiguousarray(f.field.value[:, first:last].swapaxes(0, 1)))
        f.field.value[...] = rows.swapaxes(0, 1)
