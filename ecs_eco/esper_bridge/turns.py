"""One world at a time: a process has only one esper state, so worlds in several threads take turns, tick by
tick.

Users run one world per process, or several worlds in one thread. Only the viewer runs a second world in
another thread, within `apart`.
"""

import gc
import threading
import time
import weakref
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager

from ecs_eco.engine.living import LivingWorld

_worlds: weakref.WeakSet[LivingWorld] = (
    weakref.WeakSet()
)  # worlds whose threads must not run them in parallel with other worlds
_apart = threading.local()


class _Turn:
    """A reentrant lock that is held whenever esper is used: while a world is created, in each tick, and
    within `with world:`.

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


@contextmanager
def apart() -> Iterator[None]:
    """Allow this thread to create worlds alongside those in other threads; only for threads started by this
    package."""
    _apart.allowed = True
    try:
        yield
    finally:
        _apart.allowed = False


def enter(world: LivingWorld) -> bool:
    """Register a new world; return whether its thread may run it in parallel with other worlds. If it may not
    and another living thread has a world, raise a RuntimeError."""
    me = threading.current_thread()
    if not getattr(_apart, "allowed", False) and (other := _of_others(me)):
        gc.collect()  # unreferenced worlds do not count
        if other := _of_others(me):
            raise RuntimeError(
                f"world {world.name!r}: the thread {other[0].owner.name!r} has the world {other[0].name!r}, "
                "and worlds in several threads would interfere, because esper has one state per process. "
                "Run worlds in separate processes, as ecs_eco.lab.search and `ecs-eco compare` "
                'do (multiprocessing with the context "spawn"), or one after another in one thread'
            )
    if not (allowed := bool(getattr(_apart, "allowed", False))):
        _worlds.add(world)
    return allowed


def _of_others(me: threading.Thread) -> list[LivingWorld]:
    return [w for w in list(_worlds) if w.owner is not me and w.owner.is_alive()]
