"""Bands over MPI: assign work to processes and exchange the results."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.engine.errors import ConfigError, Problem
from ecs_eco.space.one_band import OneBand

if TYPE_CHECKING:
    from mpi4py.MPI import Comm

    from ecs_eco.space.index import Index
    from ecs_eco.space.world import SpatialWorld

LEAST = 64  # with fewer organisms, every process does all the work, because an exchange would take as long


@dataclass
class Traffic:
    """Communication statistics of a process: calls, bytes received, and time [s], including waiting."""

    calls: int = 0
    received: int = 0
    seconds: float = 0.0

    def copy(self) -> Traffic:
        """Return a copy."""
        return replace(self)


class Bands(OneBand):
    """The processes of an MPI communicator, each with a band of the map, as returned by `divide`.

    A band is a range of whole rows of cells of the neighbor index, chosen for each species so that all bands
    have about the same number of its organisms. Work that is not tied to a position, such as gradients, is
    divided equally."""

    def __init__(self, world: SpatialWorld, comm: Comm, least: int = LEAST) -> None:
        self.comm, self.size, self.rank, self.least = comm, comm.Get_size(), comm.Get_rank(), least
        self.workers = world.workers
        self.traffic = Traffic()
        self.wishes = False  # whether this process has been asked to stop
        self._rows: dict[int, Any] = {}  # MPI type of a row, by size in bytes

    # --- assignment of work ---------------------------------------------------------------------------------

    def bounds(self, n: int) -> list[int]:
        """Return the `size` + 1 boundaries that divide n items among the processes."""
        return [n * k // self.size for k in range(self.size + 1)]

    def part(self, n: int) -> tuple[int, int]:
        """Return (first, last): this process handles items first … last − 1 of n independent items."""
        return n * self.rank // self.size, n * (self.rank + 1) // self.size

    def cut(self, index: Index) -> tuple[np.ndarray, np.ndarray]:
        """Return the band boundaries i64[size + 1] in rows of cells, and the same boundaries in index
        entries."""
        along = index.start[:: index.space.shape[0]]  # the first entry of each row of cells
        aims = np.array(self.bounds(index.n))
        above = np.searchsorted(along, aims)
        below = np.maximum(above - 1, 0)
        rows = np.where(aims - along[below] < along[above] - aims, below, above)
        rows[0], rows[-1] = 0, len(along) - 1
        return rows, along[rows]

    def mine(self, names: Iterable[str]) -> list[str]:
        """Return the independent items that this process handles."""
        return list(names)[self.rank :: self.size]

    # --- shared work ----------------------------------------------------------------------------------------

    def over(self, index: Index, *outputs: np.ndarray) -> AbstractContextManager[None]:
        """Within the block, restrict `World.split` over the entries of an index, or over its rows of cells,
        to this process's band. Afterward, fill in the `outputs` [index.n, …] of the other processes."""
        # with equal numbers of entries and rows, the two cases are indistinguishable
        if self.size == 1 or index.n < self.least or index.n == index.space.n_cells // index.space.shape[0]:
            return nullcontext()
        return self._over(index, outputs)

    @contextmanager
    def _over(self, index: Index, outputs: tuple[np.ndarray, ...]) -> Iterator[None]:
        rows, entries = self.cut(index)
        own = {
            n: (int(edges[self.rank]), int(edges[self.rank + 1]))
            for n, edges in ((len(index.start[:: index.space.shape[0]]) - 1, rows), (index.n, entries))
        }
        self.workers.own = lambda n: own.get(n, (0, n))
        try:
            yield
        finally:
            self.workers.own = None
        for out in outputs:
            self._complete(out, entries)

    def whole(self, n: int, *arrays: np.ndarray) -> None:
        """Complete arrays [n, …] in which each process has written only the rows of its `part(n)`."""
        for array in arrays:
            self._complete(array, self.bounds(n))

    def gathered(self, n: int, part: np.ndarray) -> np.ndarray:
        """Return the whole array [n, …] when each process has only the rows of its `part(n)`."""
        out = np.empty((n, *part.shape[1:]), part.dtype)
        first, last = self.part(n)
        out[first:last] = part
        self._complete(out, self.bounds(n))
        return out

    def share(self, arrays: dict[str, np.ndarray]) -> None:
        """Copy each named array from the process that handles it (`mine`) to all other processes."""
        if self.size == 1:
            return
        start = time.perf_counter()
        for k, array in enumerate(arrays.values()):
            self.comm.Bcast(array, root=k % self.size)
            self.traffic.received += array.nbytes if k % self.size != self.rank else 0
        self.traffic.calls += len(arrays)
        self.traffic.seconds += time.perf_counter() - start

    def _complete(self, array: np.ndarray, edges: Sequence[int] | np.ndarray) -> None:
        """Receive the rows between edges[k] and edges[k + 1] from process k, for all k."""
        size = array.itemsize * int(np.prod(array.shape[1:]))
        if not size or self.size == 1:
            return
        if not array.flags.c_contiguous:
            rows = np.ascontiguousarray(array)
            self._complete(rows, edges)
            array[...] = rows
            return
        start = time.perf_counter()
        counts = np.diff(edges)
        self.comm.Allgatherv(mpi().IN_PLACE, [array, counts, np.asarray(edges)[:-1], self._row(size)])
        self.traffic.calls += 1
        self.traffic.received += size * int(counts.sum() - counts[self.rank])
        self.traffic.seconds += time.perf_counter() - start

    def _row(self, size: int) -> Any:
        if size not in self._rows:
            self._rows[size] = mpi().BYTE.Create_contiguous(size).Commit()
        return self._rows[size]

    # --- stopping together ----------------------------------------------------------------------------------

    def stops(self) -> bool:
        """Request a stop, which takes effect when all processes `agree`."""
        self.wishes = True
        return False

    def agree(self) -> bool:
        """Return whether any process has been asked to stop; all processes call this before each tick."""
        wishes, self.wishes = self.wishes, False
        return bool(self.comm.allreduce(int(wishes)))


def mpi() -> Any:
    """Return the module mpi4py.MPI; if it is missing, raise a ConfigError with installation instructions."""
    try:
        from mpi4py import MPI
    except (ImportError, RuntimeError) as error:
        why = str(error).splitlines()[0]
        raise ConfigError(
            [
                Problem(
                    (),
                    f"needs mpi4py and an MPI library: {why}",
                    "",
                    'pip install -e ".[mpi]" in the source folder, then: mpiexec -n 4 ecs-eco run WORLD --bands',
                    "",
                    "--bands",
                )
            ]
        ) from None
    return MPI
