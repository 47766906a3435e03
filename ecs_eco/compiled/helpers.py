"""Threads that help a world's own thread, and stay awake briefly after each task so that they can start the
next at once.

Waking a sleeping thread takes about 100 µs in each direction, as long as many of the tasks in a tick. A
helper therefore polls a counter, without the GIL, for up to a millisecond before it sleeps, and so does the
thread that waits for it. After the counter changes, it pauses briefly, because the other thread still holds
the GIL until it enters a kernel, and a thread that finds the GIL taken also goes to sleep.

With `numba_version.plain()`, all threads go to sleep at once.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np

from ecs_eco.compiled.numba_version import plain

if not plain():
    from ecs_eco.compiled.parts import serve
    from ecs_eco.compiled.spinning import changes, looks_of

AWAKE = 1e-3  # [s] time for which a thread polls before it sleeps
ASKED, DONE = (
    10e-6,
    2e-6,
)  # [s] pause before taking the GIL, for a helper and for the thread that waits for it
PATIENCE = 5.0  # [s] time to wait for a thread to end


def _moved(counter: np.ndarray, last: int, pause: float) -> bool:
    if plain():
        return bool(counter[0] != last)
    return bool(changes(counter, last, looks_of(AWAKE), looks_of(pause)))


class Helper:
    """A thread for one task at a time: call `start`, do other work, then call `finish`.

    It starts with the first task and lives until `end` is called. Only one thread may use it. The GIL orders
    all writes of both threads except writes to the counters. While awake, it also takes parts of kernels from
    its team's record (`ecs_eco.compiled.parts`), if there is one."""

    def __init__(self, record: np.ndarray | None = None) -> None:
        self._record = record
        self._asked, self._done = np.zeros(1, np.int64), np.zeros(1, np.int64)  # tasks
        self._asleep = self._awaited = False
        self._bell, self._ready = threading.Semaphore(0), threading.Semaphore(0)
        self._thread: threading.Thread | None = None
        self._work: Callable[..., Any] | None = None
        self._arguments: tuple[Any, ...] = ()
        self._error: BaseException | None = None

    def start(self, work: Callable[..., Any], *arguments: object) -> None:
        """Call `work(*arguments)` in the helper, in parallel with this thread."""
        self.wake()
        self._ask(work, arguments)

    def wake(self) -> None:
        """Wake the thread so that it looks for work."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._live, name="ecs-eco helper", daemon=True)
            self._thread.start()
        elif self._asleep:
            self._asleep = False
            self._bell.release()

    def finish(self) -> None:
        """Wait until the thread has finished its task; raise the task's exception, if any."""
        asked = int(self._asked[0])
        while self._done[0] != asked and not _moved(self._done, asked - 1, DONE):
            self._awaited = True
            if self._done[0] != asked:
                self._ready.acquire()
            self._awaited = False
        error, self._error = self._error, None
        if error is not None:
            raise error

    def end(self) -> None:
        """End the thread and wait for it, because it must not be working when the process ends."""
        thread, self._thread = self._thread, None
        if thread is not None:
            self._ask(None, ())
            if thread is not threading.current_thread():
                thread.join(PATIENCE)

    def _ask(self, work: Callable[..., Any] | None, arguments: tuple[Any, ...]) -> None:
        self._work, self._arguments = work, arguments
        self._asked[0] += 1
        if self._asleep:  # each thread first publishes its own state, then reads the other's
            self._asleep = False
            self._bell.release()

    def _live(self) -> None:
        while True:
            last = int(self._done[0])
            while self._asked[0] == last and not self._served(last):
                self._asleep = True
                if self._asked[0] == last:
                    self._bell.acquire()
                self._asleep = False
            work, arguments, self._work, self._arguments = self._work, self._arguments, None, ()
            if work is None:
                return
            try:
                work(*arguments)
            except BaseException as error:  # for `finish`
                self._error = error
            del work, arguments
            self._done[0] = last + 1
            if self._awaited:
                self._ready.release()

    def _served(self, last: int) -> bool:
        """Take parts of kernels until there is a task, or until there has been nothing to do for a while."""
        if self._record is None:
            return bool(self._asked[0] != last)
        return bool(serve(self._record, self._asked, last, looks_of(AWAKE), looks_of(ASKED)))
