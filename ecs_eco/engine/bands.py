"""The bands of a world over many processes, as systems see them: this one, where one process does all.

A system says which of its work may be divided, and which arrays hold what comes of it; `ecs_eco.bands`
divides it between processes. What says nothing is done by every process alike.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import numpy as np

_everything = nullcontext()


class OneBand:
    """One process, whose band is the whole map."""

    size, rank = 1, 0

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

    def over(self, index: Any, *outputs: np.ndarray) -> AbstractContextManager[None]:
        """Within, `World.split` over the entries of an index, or over the rows of its cells, runs for this
        process's band alone; afterwards the `outputs` [index.n, …] are completed."""
        return _everything

    def mine(self, names: Iterable[str]) -> list[str]:
        """Return which of some independent things this process is to do."""
        return list(names)

    def share(self, arrays: dict[str, np.ndarray]) -> None:
        """Copy the array of each name from the process whose it is (`mine`) to all others."""
