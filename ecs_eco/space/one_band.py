"""The bands of a world divided among processes, as systems see them; this class is for a single process.

A system declares which part of its work may be divided, and which arrays hold the results; `ecs_eco.bands`
divides that part among processes. Every process does all of the remaining work.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.index import Index

T = TypeVar("T")

_everything = nullcontext()


class OneBand:
    """A single process, whose band is the whole map.

    `size` is the number of processes that hold this world, and `rank` is the index of this process. `divided`
    means that each process holds only a part of the world: its own organisms and ghosts, which are copies of
    organisms just beyond its edges. The process that owns an organism decides its fate.
    """

    size, rank = 1, 0
    divided = False
    inherited: Callable[..., Any] | None = None  # inheritance from parents in other processes

    def stops(self) -> bool:
        """Return whether a process that is asked to stop may stop alone; otherwise all processes stop at the
        same tick."""
        return True

    def part(self, n: int) -> tuple[int, int]:
        """Return which of n independent items, first … last − 1, this process handles."""
        return 0, n

    def whole(self, n: int, *arrays: np.ndarray) -> None:
        """Complete arrays [n, …] in which each process has written the rows of its `part(n)`."""

    def gathered(self, n: int, part: np.ndarray) -> np.ndarray:
        """Return the whole array [n, …], given that each process has the rows of its `part(n)`."""
        return part

    def over(self, index: Index, *outputs: np.ndarray) -> AbstractContextManager[None]:
        """Within this context, `World.split` over the entries of an index, or over its rows of cells, runs
        for this process's band only; at the end, the `outputs` [index.n, …] are completed."""
        return _everything

    def mine(self, names: Iterable[str]) -> list[str]:
        """Return which of some independent items this process handles."""
        return list(names)

    def share(self, arrays: dict[str, np.ndarray]) -> None:
        """Copy each named array from the process that owns it (`mine`) to all other processes."""

    # --- divided work if each process holds only a part of the world ---------------------------------------

    @property
    def common(self) -> OneBand:
        """The processes that share work on data that all of them hold, such as policies and rollouts."""
        return self

    def own(self, index: Index, *outputs: np.ndarray) -> AbstractContextManager[None]:
        """Like `over`, but for outputs that ghosts do not need; the rows of ghosts are undefined."""
        return self.over(index, *outputs)

    def entries(self, index: Index) -> slice:
        """Return the entries of an index that are not ghosts; they are contiguous."""
        return slice(0, index.n)

    def living(self, table: Table) -> np.ndarray:
        """Return which rows of a table are alive and not ghosts: bool[capacity]."""
        return table.alive

    def count(self, table: Table) -> int:
        """Return the number of living members of a table in all processes."""
        return table.n

    def everyone(self, *arrays: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return the arrays [n, …] of all processes concatenated, in canonical order if each part is in
        canonical order."""
        return arrays

    def litters(self, litters: Any, where: object) -> Any:
        """Return the litters of all processes, ordered by their parents' uids."""
        return litters

    def holds(self, y: np.ndarray) -> np.ndarray | None:
        """Return which positions f32[n] [m] are in the band of this process: bool[n]; None means all of
        them."""
        return None

    def either(self, flags: np.ndarray) -> np.ndarray:
        """Return which flags bool[…] are set in at least one process."""
        return flags

    def sites(self, table: Table, stands: np.ndarray) -> np.ndarray:
        """Return the plant on each site i64[ny, nx] (−1: none), given by its row, or by its uid if no process
        has all rows."""
        return stands

    def learnt(self, minds: object, *arrays: np.ndarray) -> tuple[np.ndarray, ...]:
        """Record what individuals have learned in this tick, with one entry per individual; return the
        record."""
        return arrays

    def undivided(self, world: T) -> T | None:
        """Return the whole world in the one process that displays it or writes it to a file; None in all
        other processes."""
        return world

    def ask(self, what: Callable[[Any], Any]) -> Any:
        """Return, in all processes, the result of a function of the whole divided world."""
        raise NotImplementedError

    def collect(self, recorder: object) -> None:
        """Send the records of all processes since the last call to the process that writes them."""
