"""Messages between the processes of a world: table rows as bytes, and concatenated arrays."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.bands.bands import Traffic, mpi

if TYPE_CHECKING:
    from mpi4py.MPI import Comm
    from numpy.typing import DTypeLike

    from ecs_eco.engine.table import Table

OWN = {"uid": np.uint64, "born": np.int64, "cause": np.uint8, "killer": np.uint64}
TAG = 17


class Wire:
    """The connection of a process to the others in its communicator, with traffic statistics."""

    def __init__(self, comm: Comm) -> None:
        self.comm, self.size, self.rank = comm, comm.Get_size(), comm.Get_rank()
        self.traffic = Traffic()

    def swap(self, parts: Mapping[int, np.ndarray]) -> dict[int, np.ndarray]:
        """Send bytes u8[…] to each rank; return the bytes received, by rank. All processes must call this."""
        if self.size == 1:
            return {}
        start, comm = time.perf_counter(), self.comm
        sizes, coming = np.zeros(self.size, np.int64), np.empty(self.size, np.int64)
        for rank, part in parts.items():
            sizes[rank] = part.size
        comm.Alltoall(sizes, coming)
        got = {int(rank): np.empty(coming[rank], np.uint8) for rank in np.flatnonzero(coming)}
        waits = [comm.Irecv(buffer, rank, TAG) for rank, buffer in got.items()]
        waits += [comm.Isend(part, rank, TAG) for rank, part in parts.items() if part.size]
        mpi().Request.Waitall(waits)
        self._note(start, int(coming.sum()))
        return got

    def everyone(self, *arrays: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return arrays [n, …] concatenated over all processes in rank order; all arrays of a process have
        the same n."""
        if self.size == 1:
            return arrays
        start, comm = time.perf_counter(), self.comm
        arrays = tuple(np.ascontiguousarray(array) for array in arrays)
        counts = np.empty(self.size, np.int64)
        comm.Allgather(np.array([len(arrays[0])]), counts)
        each = [array.itemsize * int(np.prod(array.shape[1:])) for array in arrays]
        sizes = counts * sum(each)
        out = np.empty(int(sizes.sum()), np.uint8)
        if out.size:
            begins = np.concatenate([[0], np.cumsum(sizes)[:-1]])
            mine = np.concatenate([array.reshape(-1).view(np.uint8) for array in arrays])
            comm.Allgatherv(mine, [out, sizes, begins, mpi().BYTE])
        self._note(start, out.size - int(sizes[self.rank]))
        return tuple(self._joined(out, counts, each, i, array) for i, array in enumerate(arrays))

    @staticmethod
    def _joined(
        out: np.ndarray, counts: np.ndarray, each: Sequence[int], i: int, like: np.ndarray
    ) -> np.ndarray:
        """Return array i of every process, given bytes in which the arrays of each process are contiguous."""
        before, pieces, at = sum(each[:i]), [], 0
        for n in counts.tolist():
            first = at + n * before
            pieces.append(out[first : first + n * each[i]])
            at += n * sum(each)
        return np.concatenate(pieces).view(like.dtype).reshape(int(counts.sum()), *like.shape[1:])

    def any(self, flags: np.ndarray) -> np.ndarray:
        """Return whether each flag is set in at least one process: bool[…]."""
        if self.size == 1 or not flags.size:
            return flags
        start, out = time.perf_counter(), np.empty(flags.shape, np.uint8)
        self.comm.Allreduce(np.ascontiguousarray(flags).view(np.uint8), out, op=mpi().BOR)
        self._note(start, out.nbytes)
        return out.view(np.bool_)

    def total(self, numbers: np.ndarray) -> np.ndarray:
        """Return the sum of integers i64[n] over all processes."""
        if self.size == 1:
            return numbers
        start, out = time.perf_counter(), np.empty_like(numbers)
        self.comm.Allreduce(numbers, out)
        self._note(start, out.nbytes)
        return out

    def _note(self, start: float, received: int) -> None:
        self.traffic.calls += 1
        self.traffic.received += received
        self.traffic.seconds += time.perf_counter() - start


# --- rows of tables as bytes --------------------------------------------------------------------------------


Columns = list[tuple[Any, str]]


def columns_of(table: Table, heavy: bool, seen: Sequence[type] | None = None) -> Columns:
    """Return the (component, field) pairs of a table, with blocked fields only if `heavy`, and only for the
    components in `seen`, if given."""
    return [
        (component, field)
        for component, held in table.columns.items()
        for field in vars(held)
        if (heavy or not component.fields[field][0].blocked) and (seen is None or component in seen)
    ]


def packed(groups: Iterable[tuple[Table, np.ndarray]], columns: Mapping[str, Columns]) -> np.ndarray:
    """Pack the given rows i64[k] of each table, with its `columns`, into bytes u8[…]."""
    groups = list(groups)
    pieces = [np.array([rows.size for _, rows in groups], np.int64)]
    for table, rows in groups:
        if rows.size:
            pieces += [getattr(table, name)[rows] for name in OWN]
            pieces += [getattr(table[component], field)[rows] for component, field in columns[table.name]]
    return np.concatenate([np.ascontiguousarray(piece).reshape(-1).view(np.uint8) for piece in pieces])


def settled(
    tables: Sequence[Table], data: np.ndarray, columns: Mapping[str, Columns]
) -> tuple[list[np.ndarray], np.ndarray]:
    """Add rows packed by `packed` to the tables; return the new rows i64[k] and the remaining bytes."""
    taken = 8 * len(tables)
    counts, rows = data[:taken].view(np.int64), []

    def read(n: int, dtype: DTypeLike, inner: tuple[int, ...] = ()) -> np.ndarray:
        nonlocal taken
        size = n * np.dtype(dtype).itemsize * int(np.prod(inner))
        out = data[taken : taken + size].copy().view(dtype).reshape(n, *inner)
        taken += size
        return out

    for table, n in zip(tables, counts.tolist(), strict=True):
        if not n:
            rows.append(np.zeros(0, np.int64))
            continue
        own = {name: read(n, dtype) for name, dtype in OWN.items()}
        values = {}
        for component, field in columns[table.name]:
            column = getattr(table[component], field)
            values[component, field] = read(n, column.dtype, column.shape[1:])
        rows.append(table.settle(own["uid"], own["born"], values, whole=False))
        table.cause[rows[-1]], table.killer[rows[-1]] = own["cause"], own["killer"]
    return rows, data[taken:]
