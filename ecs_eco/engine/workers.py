"""The threads of one world: parts of a kernel's range, or independent pieces of work.

Their number changes no result. Whether the work of a tick is divided is measured, tick by tick: other threads
are no gain where they cost more than they do, or where their cores have other work.
"""

from __future__ import annotations

import threading
import time
import weakref
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ecs_eco.engine.helpers import Helper

PARALLEL_FROM = 3000  # organisms of some 30 ns each: fewer do not repay a second thread; 0: all is divided
PART = 3000  # organisms of some 30 ns each, for which Python may be asked once more
MOST_PARTS = 4  # of one kernel, for each thread
EASE = 4  # pieces of Python take turns: so many times as many organisms repay a second thread
SAMPLES = 5  # ticks of each way, of which the median counts: in some, kernels are compiled
AGAIN, RARELY = 32, 128  # ticks after which the way that took longer is tried again: at first, and in the end


class Pace:
    """What ticks took lately, in seconds an organism: divided between threads, and done by one alone.

    The way that took longer is tried again, more and more rarely; at once where it took less time just now.
    """

    def __init__(self) -> None:
        self.ticks = self.due = 0  # `due`: the tick in which the other way is tried
        self.wait = AGAIN  # ticks from one try to the next
        self.alone: deque[float] = deque(maxlen=SAMPLES)
        self.divided: deque[float] = deque(maxlen=SAMPLES)
        self.better = True  # divided

    def divide(self) -> bool:
        """Return whether to divide the next tick."""
        self.ticks += 1
        if len(self.alone) < SAMPLES:
            return len(self.divided) < SAMPLES
        return self.better != (self.ticks >= self.due)

    def note(self, divided: bool, seconds: float) -> None:
        """Keep what a tick took."""
        (self.divided if divided else self.alone).append(seconds)
        if not len(self.alone) == len(self.divided) == SAMPLES:
            return
        alone, several = (sorted(ticks)[SAMPLES // 2] for ticks in (self.alone, self.divided))
        was, self.better = self.better, several < alone
        if self.better != was:
            self.wait = AGAIN
            self.due = self.ticks + self.wait
        elif divided != was:  # it was a try
            gain = seconds < min(alone, several)
            self.wait = AGAIN if gain else min(2 * self.wait, RARELY)
            self.due = self.ticks + (1 if gain else self.wait)


class Workers:
    """The world's own thread, and `threads` − 1 others."""

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self.helpers = _helpers(threads - 1)
        self._taken = threading.Lock()  # held by the thread that divides work
        self.all_busy = False  # whether all threads are busy in `together`: its pieces are not split further
        # which part of 0…n this process does, while it shares work with others (ecs_eco.bands)
        self.own: Callable[[int], tuple[int, int]] | None = None
        self.alone = False  # whether the world's own thread does all work of this tick
        self.pace = Pace()
        self._divided = False  # whether some work of this tick could be divided
        self._end = weakref.finalize(self, _end, self.helpers)

    def tick(self, process: Callable[[], Any], organisms: Callable[[], int]) -> None:
        """Let a tick pass in the way that took less time lately."""
        if not self.helpers or PARALLEL_FROM <= 0:
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
        if not self.helpers or self.all_busy or items < PARALLEL_FROM:
            return False
        self._divided = True
        return not self.alone and self._taken.acquire(blocking=False)

    def split(self, kernel: Callable[..., Any], n: int, *arguments: Any, work: int | None = None) -> None:
        """Run `kernel(first, last, *arguments)` over 0…n, in parts on all threads
        where `work` items are worth it."""
        if not self.helpers and self.own is None:
            kernel(0, n, *arguments)
            return
        start, stop = (0, n) if self.own is None else self.own(n)
        work = n if work is None else work
        if not self._worth(work):
            kernel(start, stop, *arguments)
            return
        # more parts than threads: who comes late, as its core had other work, leaves more to the others
        k = min(max(work // PART, self.threads), MOST_PARTS * self.threads)
        bounds = [start + (stop - start) * i // k for i in range(k + 1)]
        first, *others = zip(bounds, bounds[1:], strict=False)
        self._take_turns(partial(kernel, *first, *arguments),
                         [partial(kernel, *part, *arguments) for part in others])

    def together(self, tables: Iterable[Any], *work: Callable[[], Any]) -> None:
        """Do independent pieces of work, the first on this thread and the others on all where there are many
        organisms in the tables; they must not share what they write."""
        if not self.helpers or self.all_busy or not work or not self._worth(sum(t.n for t in tables) // EASE):
            for piece in work:
                piece()
            return
        self.all_busy = True
        try:
            self._take_turns(work[0], work[1:])
        finally:
            self.all_busy = False

    def _take_turns(self, first: Callable[[], Any], others: Sequence[Callable[[], Any]]) -> None:
        """Do pieces of work, the first on this thread; whoever is ready takes the next of the others."""
        pieces = iter(others)

        def take(*own: Callable[[], Any]) -> None:
            for piece in chain(own, pieces):
                piece()

        self._share([(take,)] * min(len(self.helpers), len(others)), take, first)

    def _share(self, jobs: Sequence[tuple[Any, ...]], work: Callable[..., Any], *arguments: Any) -> None:
        """Let helpers do the jobs, functions with their arguments, and this thread its own work; wait for
        all, and raise what one of them raised."""
        busy, errors = [], []
        try:
            for helper, job in zip(self.helpers, jobs, strict=False):
                helper.start(*job)
                busy.append(helper)
            work(*arguments)
        finally:  # after an error, too, no thread still works on the world
            for helper in busy:
                errors += _end_of(helper)
            self._taken.release()
        if errors:
            raise errors[0]

    def end(self) -> None:
        """Let the other threads end: from now on this one does all work."""
        helpers, self.helpers = self.helpers, []
        _end(helpers)


def _helpers(n: int) -> list[Helper]:
    if not n:
        return []
    from ecs_eco.engine.helpers import Helper

    return [Helper() for _ in range(n)]


def _end_of(helper: Helper) -> list[BaseException]:
    """Wait until a helper has done its work; return what was raised meanwhile."""
    errors: list[BaseException] = []
    while True:
        try:
            helper.finish()
        except KeyboardInterrupt as error:  # this thread was interrupted, and the helper is still at work
            errors.append(error)
        except BaseException as error:
            return [*errors, error]
        else:
            return errors


def _end(helpers: Iterable[Helper]) -> None:
    for helper in helpers:
        helper.end()
