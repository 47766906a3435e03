"""One world at a time: a process has only one esper state, so worlds in several threads take turns, tick by
tick, unless their ticks use neither esper nor torch.
"""

from __future__ import annotations

import threading
import time
from collections import deque


class _Turn:
    """A reentrant lock that is held whenever esper is used: in ticks that may use it, and within
    `with world:`.

    If a thread released an ordinary lock and reacquired it at once, waiting threads would never get it. After
    its turn, a thread therefore calls `leave`, which gives the next turn to a waiting thread.
    """

    PATIENCE = 1.0  # [s] longest wait for another thread to take its turn, even on a loaded machine

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self.waiting = 0  # threads
        self._taken = 0  # turns for which a thread had to wait
        self._returned: deque[int] = deque()  # threads whose turns another thread has ended

    def __enter__(self) -> None:
        if not self._lock.acquire(False):
            self.waiting += 1
            try:
                self._lock.acquire()
                self._taken += 1
            finally:
                self.waiting -= 1

    def __exit__(self, *_: object) -> None:
        self._lock.release()
        if not self._returned:
            return
        me = threading.get_ident()
        while me in self._returned and self.held():
            self._returned.remove(me)
            self._lock.release()

    def held(self) -> bool:
        """Whether this thread has the turn."""
        return self._lock._is_owned()  # type: ignore[attr-defined]

    def give_back(self, times: int, thread: int) -> None:
        """End the turns of a freed world, which its thread can no longer end; any thread may collect garbage.

        If another thread holds these turns, they end when it next ends a turn, because only the owner can
        release a lock.
        """
        for _ in range(times):
            if thread == threading.get_ident():
                self._lock.release()
            else:
                self._returned.append(thread)

    def leave(self) -> None:
        """Give way to waiting threads, unless this thread still holds the turn, as it does in `with world:`."""
        if self.held():
            return
        taken, end = self._taken, time.monotonic() + self.PATIENCE
        while self.waiting and self._taken == taken and time.monotonic() < end:
            time.sleep(1e-4)


turn = _Turn()
