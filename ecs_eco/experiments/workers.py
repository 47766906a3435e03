"""Worker processes: each has one thread and ends with its parent process."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from ecs_eco.engine.processes import SAFE

PINS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
ENDED = 130  # exit code of a worker that was told to end


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Processes that start within use one thread each, and import nothing from the folder that they run in."""
    before = {name: os.environ.get(name) for name in (*PINS, SAFE)}
    os.environ.update(dict.fromkeys(before, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def begin_worker() -> None:
    """Leave Ctrl-C to the parent process, and end with it; to be called as a worker starts."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()


def end_with_parent() -> None:
    """Have this process get SIGTERM when its parent ends; to be called as a worker starts.

    A pool's workers wait on a pipe of which they hold both ends: if their parent is killed,
    they would go on with all that is queued.
    """
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def wait() -> None:
        parent.join()
        os.kill(os.getpid(), signal.SIGTERM)

    threading.Thread(target=wait, daemon=True).start()


@contextmanager
def finishing() -> Iterator[None]:
    """Raise KeyboardInterrupt within when the worker is told to end, so that the work can save what it has.

    Elsewhere nothing changes: Ctrl-C raises KeyboardInterrupt anyway, and a thread beside the main one, in
    which Dask's workers have their calls, hears no signals.
    """
    if multiprocessing.parent_process() is None or threading.current_thread() is not threading.main_thread():
        yield
        return

    told = over = False

    def interrupt(*_: object) -> None:
        nonlocal told
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        if over:
            os._exit(ENDED)
        told = True
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        try:
            yield
        finally:
            over = True
    except KeyboardInterrupt:
        os._exit(ENDED)
    finally:
        if told:  # and what was raised got lost on its way, as it does in a destructor
            os._exit(ENDED)
        signal.signal(signal.SIGTERM, before)
