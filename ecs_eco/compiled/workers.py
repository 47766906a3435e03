"""The threads of one world, which do parts of a kernel's range or independent pieces of work.

Their number does not affect results. Measurements decide, tick by tick, whether to divide work: more threads
do not pay off if they cost more time than they save, or if their cores are busy.
"""

from __future__ import annotations

import threading
import time
import weakref
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import chain
from typing import Any

from ecs_eco.compiled.helpers import Helper
from ecs_eco.compiled.numba_version import plain
from ecs_eco.compiled.pace import Pace

if not plain():
    from ecs_eco.compiled.team import Team
PARALLEL_FROM = 1500  # organisms (about 30 ns each) below which one thread is faster; 0: divide everything
PART = 1000  # organisms per part, at about 30 ns each, so that other threads can do a late thread's work
MOST_PARTS = 4  # per kernel per thread
EASE = 8  # Python code runs in one thread at a time, so it needs this many times as many organisms
IDLE = 32  # single-threaded ticks after a tick in which no work was worth dividing


class Workers:
    """The world's own thread and `threads` − 1 other threads."""

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self.team = None if threads == 1 or plain() else Team(threads - 1)
        self.helpers = [Helper() for _ in range(threads - 1)] if self.team is None else self.team.helpers
        self._taken = threading.Lock()  # held by the thread that divides work
        self.all_busy = False  # whether all threads are busy in `together`: then pieces are not split further
        # the part of 0…n that this process does while it shares work with other processes (ecs_eco.bands)
        self.own: Callable[[int], tuple[int, int]] | None = None
        self.parallel = threads > 1  # whether other threads take part; if not, this thread does all work
        self.pace = Pace()
        self._divided = False  # whether any work was divided in the last tick that permitted it
        self._idle = 0  # ticks until division is permitted again
        self._end = weakref.finalize(self, _end, self.helpers)

    def tick(self, process: Callable[[], Any], organisms: Callable[[], int]) -> None:
        """Run a tick in the mode that was recently faster."""
        if not self.helpers or PARALLEL_FROM <= 0:
            process()
            return
        if self._idle:
            self._idle -= 1
            self.parallel = False
        elif self.pace.divide():
            self._divided = False
        else:
            self.parallel = False
        begin = time.perf_counter()
        try:
            process()
            if self._divided:
                self.pace.note(self.parallel, time.perf_counter() - begin, max(organisms(), 1))
            elif self.parallel:
                self._idle = IDLE
        finally:
            self.parallel = bool(self.helpers)

    def _worth(self, items: int) -> bool:
        """Return whether work with this many items should be divided."""
        if self.all_busy or items < PARALLEL_FROM or not self._taken.acquire(blocking=False):
            return False
        self._divided = True
        return True

    def split(self, kernel: Callable[..., Any], n: int, *arguments: object, work: int | None = None) -> None:
        """Run `kernel(first, last, *arguments)` over 0…n, on all threads if there is enough `work`."""
        if not self.parallel and self.own is None:
            kernel(0, n, *arguments)
            return
        start, stop = (0, n) if self.own is None else self.own(n)
        work = n if work is None else work
        if not self.parallel or not self._worth(work):
            kernel(start, stop, *arguments)
            return
        # more parts than threads, so that other threads can take over from a late thread whose core was busy
        k = min(max(work // PART, self.threads), MOST_PARTS * self.threads)
        if self.team is not None and self.team.divides(kernel):
            try:
                self.team.run(kernel, start, stop, k, arguments)
            finally:
                self._taken.release()
            return
        bounds = [start + (stop - start) * i // k for i in range(k + 1)]
        first, *others = zip(bounds, bounds[1:], strict=False)
        self._take_turns(
            partial(kernel, *first, *arguments), [partial(kernel, *part, *arguments) for part in others]
        )

    def together(self, tables: Iterable[Any], *work: Callable[[], Any]) -> None:
        """Do independent pieces of work, which must not write to the same data: the first on this thread, the
        rest on all threads if the tables have many organisms."""
        if not self.parallel or not work or not self._worth(sum(t.n for t in tables) // EASE):
            for piece in work:
                piece()
            return
        self.all_busy = True
        try:
            self._take_turns(work[0], work[1:])
        finally:
            self.all_busy = False

    def _take_turns(self, first: Callable[[], Any], others: Sequence[Callable[[], Any]]) -> None:
        """Do pieces of work, the first one on this thread; each thread takes the next piece when it is
        ready."""
        pieces = iter(others)

        def take(*own: Callable[[], Any]) -> None:
            for piece in chain(own, pieces):
                piece()

        self._share([(take,)] * min(len(self.helpers), len(others)), take, first)

    def _share(self, jobs: Sequence[tuple[Any, ...]], work: Callable[..., Any], *arguments: object) -> None:
        """Run the jobs (functions with their arguments) on helpers and `work` on this thread; wait for all,
        and raise the first exception of any helper."""
        busy, errors = [], []
        try:
            for helper, job in zip(self.helpers, jobs, strict=False):
                helper.start(*job)
                busy.append(helper)
            work(*arguments)
        finally:  # even after an error, no thread uses the world any longer
            for helper in busy:
                errors += _end_of(helper)
            self._taken.release()
        if errors:
            raise errors[0]

    def end(self) -> None:
        """End the other threads; from now on, this thread does all the work."""
        helpers, self.helpers, self.parallel = self.helpers, [], False
        _end(helpers)


def _end_of(helper: Helper) -> list[BaseException]:
    """Wait until a helper has finished; return the exceptions raised meanwhile."""
    errors: list[BaseException] = []
    while True:
        try:
            helper.finish()
        except KeyboardInterrupt as error:  # this thread was interrupted, but the helper is still working
            errors.append(error)
        except BaseException as error:
            return [*errors, error]
        else:
            return errors


def _end(helpers: Iterable[Helper]) -> None:
    for helper in helpers:
        helper.end()
