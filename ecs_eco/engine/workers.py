"""The threads of one world: parts of a kernel's range, or independent pieces of work.

Their number changes no result.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Any

PARALLEL_FROM = 3000  # fewer organisms than this do not repay a second thread


class Workers:
    """The world's own thread, and `threads` − 1 others."""

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self.pool = ThreadPoolExecutor(threads - 1) if threads > 1 else None
        self.all_busy = False  # whether all threads are busy in `together`: its pieces are not split further
        # which part of 0…n this process does, while it shares work with others (ecs_eco.bands)
        self.own: Callable[[int], tuple[int, int]] | None = None

    def split(self, kernel: Callable[..., Any], n: int, *arguments: Any, work: int | None = None) -> None:
        """Run `kernel(first, last, *arguments)` over 0…n, in parts on all threads
        where `work` items are worth it."""
        if self.pool is None and self.own is None:
            kernel(0, n, *arguments)
            return
        start, stop = (0, n) if self.own is None else self.own(n)
        pool = self.pool
        if pool is None or self.all_busy or (n if work is None else work) < PARALLEL_FROM:
            kernel(start, stop, *arguments)
            return
        bounds = [start + (stop - start) * i // self.threads for i in range(self.threads + 1)]
        others = [pool.submit(kernel, a, b, *arguments) for a, b in zip(bounds[1:], bounds[2:], strict=False)]
        _here_and(others, lambda: kernel(start, bounds[1], *arguments))

    def together(self, tables: Iterable[Any], *work: Callable[[], Any]) -> None:
        """Do independent pieces of work, on all threads where there are many organisms in the tables;
        they must not share what they write."""
        pool = self.pool
        if pool is None or self.all_busy or not work or sum(t.n for t in tables) < PARALLEL_FROM:
            for piece in work:
                piece()
            return
        self.all_busy = True
        try:
            _here_and([pool.submit(piece) for piece in work[1:]], work[0])
        finally:
            self.all_busy = False

    def end(self) -> None:
        """Let the other threads end."""
        if self.pool is not None:
            self.pool.shutdown(wait=False)


def _here_and(others: list[Future[Any]], work: Callable[[], Any]) -> None:
    """Do the work of this thread and wait for the others; raise what one of them raised."""
    try:
        work()
    finally:
        wait(others)  # after an error no thread still works on the world
    for part in others:
        part.result()
