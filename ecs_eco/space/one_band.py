"""The bands of a world over many processes, as systems see them: this one, where one process does all.

A system says which of its work may be divided, and which arrays hold what comes of it; `ecs_eco.bands`
divides it between processes. What says nothing is done by every process alike.
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
    """One process, whose band is the whole map.

    `size` is the number of processes that hold this same world, and `rank` the place of this one among them.
    `divided` says that each holds a part alone, its own organisms and copies of those beyond its edges:
    ghosts, whose own processes decide what becomes of them.
    """

    size, rank = 1, 0
    divided = False
    inherited: Callable[..., Any] | None = None  # what newborn inherit, where parents are in other processes

    def stops(self) -> bool:
        """Return whether a world that is told to stop may do so by itself; else all stop at the same tick."""
        return True

    def part(self, n: int) -> tuple[int, int]:
        """Return which of n independent items, first … last − 1, this process is to do."""
        return 0, n

    def whole(self, n: int, *arrays: np.ndarray) -> None:
        """Complete arrays [n, …] of which each process has written the rows of its `part(n)`."""

    def gathered(self, n: int, part: np.ndarray) -> np.ndarray:
        """Return an array [n, …] of which each process has the rows of its `part(n)`."""
        return part

    def over(self, index: Index, *outputs: np.ndarray) -> AbstractContextManager[None]:
        """Within, `World.split` over the entries of an index, or over the rows of its cells, runs for this
        process's band alone; afterwards the `outputs` [index.n, …] are completed."""
        return _everything

    def mine(self, names: Iterable[str]) -> list[str]:
        """Return which of some independent things this process is to do."""
        return list(names)

    def share(self, arrays: dict[str, np.ndarray]) -> None:
        """Copy the array of each name from the process whose it is (`mine`) to all others."""

    # --- what is divided where each process holds a part of the world alone ---------------------------------

    @property
    def common(self) -> OneBand:
        """The processes that share work on what all of them hold: policies and rollouts."""
        return self

    def own(self, index: Index, *outputs: np.ndarray) -> AbstractContextManager[None]:
        """Do as `over`, for what ghosts need not have: their rows of the outputs mean nothing."""
        return self.over(index, *outputs)

    def entries(self, index: Index) -> slice:
        """Return which entries of an index are no ghosts: they are in one piece."""
        return slice(0, index.n)

    def living(self, table: Table) -> np.ndarray:
        """Return which rows of a table live and are no ghosts: bool[capacity]."""
        return table.alive

    def count(self, table: Table) -> int:
        """Return how many of a table live, in all processes."""
        return table.n

    def everyone(self, *arrays: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return arrays [n, …] with those of all processes behind one another: in canonical order, if each
        stands in this order."""
        return arrays

    def litters(self, litters: Any, where: object) -> Any:
        """Return the litters of all processes in the order of their parents' uids."""
        return litters

    def holds(self, y: np.ndarray) -> np.ndarray | None:
        """Return which places f32[n] [m] are in the band of this process: bool[n]; None: all."""
        return None

    def either(self, flags: np.ndarray) -> np.ndarray:
        """Return which flags bool[…] are set in any process."""
        return flags

    def sites(self, table: Table, stands: np.ndarray) -> np.ndarray:
        """Return what stands on each site i64[ny, nx], −1 for nothing: the rows of plants, or their uids
        where no process has all rows."""
        return stands

    def learnt(self, minds: object, *arrays: np.ndarray) -> tuple[np.ndarray, ...]:
        """Note what individuals have learnt in this tick, an entry each; return it."""
        return arrays

    def undivided(self, world: T) -> T | None:
        """Return the whole world, in the one process that looks at it or writes it to a file; None elsewhere."""
        return world

    def ask(self, what: Callable[[Any], Any]) -> Any:
        """Return what a function says of the whole of a divided world, in all processes that ask."""
        raise NotImplementedError

    def collect(self, recorder: object) -> None:
        """Bring what all processes have recorded since the last time to the one that writes it."""
