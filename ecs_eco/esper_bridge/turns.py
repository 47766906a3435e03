"""One world at a time: a process has only one esper state, so worlds in several threads take turns, tick by
tick, unless their ticks use neither esper nor torch.
"""

from __future__ import annotations

import threading
import time


class _Turn:
    """A reentrant lock that is held whenever esper is used: in ticks that may use it, and within
    `with world:`. Any thread may end another's turns, because any thread may collect a world that was
    abandoned within its `with` block.

    If a thread released the lock and reacquired it at once, waiting threads would never get it. After
    its turn, a thread therefore calls `leave`, which gives the next turn to a waiting thread.
    """

    PATIENCE = 1.0  # [s] longest wait for another thread to take its turn, even on a loaded machine

    def __init__(self) -> None:
        # reentrant: collecting garbage may call `give_back` in a thread that is within a method here
        self._change = threading.Condition(threading.RLock())
        self._owner: int | None = None  # thread that has the turn
        self._depth = 0  # times that it has entered
        self.waiting = 0  # threads
        self._taken = 0  # turns for which a thread had to wait

    def __enter__(self) -> None:
        me = threading.get_ident()
        with self._change:
            if self._owner not in (None, me):
                self.waiting += 1
                try:
                    while self._owner is not None:
                        self._change.wait(self.PATIENCE)  # a collection just before the wait is not notified
                    self._taken += 1
                finally:
                    self.waiting -= 1
            self._owner = me
            self._depth += 1

    def __exit__(self, *_: object) -> None:
        self.give_back(1, threading.get_ident())

    def held(self) -> bool:
        """Whether this thread has the turn."""
        return self._owner == threading.get_ident()

    def give_back(self, times: int, thread: int) -> None:
        """End turns of a thread: its own, or those of a freed world that it can no longer end."""
        with self._change:
            if self._owner == thread:
                self._depth -= times
                if not self._depth:
                    self._owner = None
                    self._change.notify()

    def leave(self) -> None:
        """Give way to waiting threads, unless this thread still holds the turn, as it does in `with world:`."""
        if self.held():
            return
        taken, end = self._taken, time.monotonic() + self.PATIENCE
        while self.waiting and self._taken == taken and time.monotonic() < end:
            time.sleep(1e-4)


turn = _Turn()
