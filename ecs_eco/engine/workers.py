"""The threads of one world: parts of a kernel's range, or independent pieces of work.

Their number changes no result. Whether the work of a tick is divided is measured, tick by tick: other threads
are no gain where they cost more than they do, or where their cores have other work.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Any

PARALLEL_FROM = 3000  # fewer organisms than this do not repay a second thread; 0: all work is divided
SAMPLES = 5  # ticks of each way, of which the median counts: in some, kernels are compiled
AGAIN = 32  # ticks after which the way that took longer is tried again


class Pace:
    """What ticks took lately, in seconds an organism: divided between threads, and done by one alone."""

    def __init__(self) -> None:
        self.ticks = 0
        self.alone: deque[float] = deque(maxlen=SAMPLES)
        self.divided: deque[float] = deque(maxlen=SAMPLES)
        self.better = True  # divided

    def divide(self) -> bool:
        """Return whether to divide the next tick."""
        self.ticks += 1
        if len(self.alone) < SAMPLES:
            return len(self.divided) < SAMPLES
        return self.better != (self.ticks % AGAIN == 0)

    def note(self, divided: bool, seconds: float) -> None:
        """Keep what a tick took."""
        (self.divided if divided else self.alone).append(seconds)
        if len(self.alone) == len(self.divided) == SAMPLES:
            middle = SAMPLES // 2
            self.better = sorted(self.divided)[middle] < sorted(self.alone)[middle]


class Workers:
    """The world's own thread, and `threads` − 1 others."""

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self.pool = ThreadPoolExecutor(threads - 1) if threads > 1 else None
        self.all_busy = False  # whether all threads are busy in `together`: its pieces are not split further
        # which part of 0…n this process does, while it shares work with others (ecs_eco.bands)
        self.own: Callable[[int], tuple[int, int]] | None = None
        self.alone = False  # whether the world's own thread does all work of this tick
        self.pace = Pace()
        self._divided = False  # whether some work of this tick could be divided

    def tick(self, process: Callable[[], Any], organisms: Callable[[], int]) -> None:
        """Let a tick pass in the way that took less time lately."""
        if self.pool is None or PARALLEL_FROM <= 0:
            process()
            return
        self.alone, self._divided, begin = not self.pace.divide(), False, time.perf_counter()
        try:
            process()
            if self._divided:
                self.pace.note(not self.alone, (time.perf_counter() - begin) / max(organisms(), 1))
        finally:
            self.alone = False

    def _worth(self, items: int) -> bool:
        """Return whether work with this many items is to be divided."""
        if self.pool is None or self.all_busy or items < PARALLEL_FROM:
            return False
        self._divided = True
        return not self.alone

    def split(self, kernel: Callable[..., Any], n: int, *arguments: Any, work: int | None = None) -> None:
        """Run `kernel(first, last, *arguments)` over 0…n, in parts on all threads
        where `work` items are worth it."""
        if self.pool is None and self.own is None:
            kernel(0, n, *arguments)
            return
        start, stop = (0, n) if self.own is None else self.own(n)
        pool = self.pool
        if pool is None or not self._worth(n if work is None else work):
            kernel(start, stop, *arguments)
            return
        bounds = [start + (stop - start) * i // self.threads for i in range(self.threads + 1)]
        others = [pool.submit(kernel, a, b, *arguments) for a, b in zip(bounds[1:], bounds[2:], strict=False)]
        _here_and(others, lambda: kernel(start, bounds[1], *arguments))

    def together(self, tables: Iterable[Any], *work: Callable[[], Any]) -> None:
        """Do independent pieces of work, on all threads where there are many organisms in the tables;
        they must not share what they write."""
        pool = self.pool
        if pool is None or self.all_busy or not work or not self._worth(sum(t.n for t in tables)):
            for piece in work:
                piece()
            return
        self.all_busy = True
        try:
            _here_and([pool.submit(piece) for piece in work[1:]], work[0])
        finally:
            self.all_busy = False

    def end(self) -> None:
        """Let the other threads end, once nobody divides work between them any more: `split` may be held by
        those that do not hold the world."""
        self.pool = None


def _here_and(others: list[Future[Any]], work: Callable[[], Any]) -> None:
    """Do the work of this thread and wait for the others; raise what one of them raised."""
    try:
        work()
    finally:
        wait(others)  # after an error no thread still works on the world
    for part in others:
        part.result()
