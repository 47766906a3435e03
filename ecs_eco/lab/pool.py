"""Worker processes for comparisons, searches and studies."""

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from types import TracebackType
from typing import Any, TypeVar

from ecs_eco.engine.errors import FolderInUse
from ecs_eco.engine.processes import SAFE

Result = TypeVar("Result")
PINS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
ENDED = 130  # exit code of a worker that was asked to end
PATIENCE = 150.0  # [s] to wait for a folder whose owner was lost; longer than the leases of shared disks


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Start processes in this context with one thread and without imports from their folder."""
    pins = dict.fromkeys((*PINS, SAFE), "1")
    before = {name: os.environ[name] for name in pins if name in os.environ}
    os.environ.update(pins)
    try:
        yield
    finally:
        for name in pins:
            del os.environ[name]
        os.environ.update(before)


def begin_worker() -> None:
    """Leave Ctrl-C to the parent process, and send SIGTERM to this one when its parent ends, because a pool's
    workers would keep running queued calls; call this when a worker starts."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def wait() -> None:
        parent.join()
        os.kill(os.getpid(), signal.SIGTERM)

    threading.Thread(target=wait, daemon=True).start()


def once_free(call: Callable[[], Result], patience: float, pause: float = 1.0) -> Result:
    """Call a function, retrying while another process holds the folder, for at most `patience` [s]."""
    until = time.monotonic() + patience
    while True:
        try:
            return call()
        except FolderInUse:
            if time.monotonic() > until:
                raise
            time.sleep(pause)


@contextmanager
def finishing() -> Iterator[None]:
    """Raise KeyboardInterrupt within this context when the worker is asked to end, so that it saves its state.
    Elsewhere, Ctrl-C does this; Dask workers run calls outside the main thread, where no signals arrive."""
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
        if told:  # the exception was lost, for example in a destructor
            os._exit(ENDED)
        signal.signal(signal.SIGTERM, before)


class Pool(Executor):
    """An executor with single-threaded workers that end with this process; if there is only one worker, it is
    this process itself. Only this process receives Ctrl-C; an exception that leaves the `with` block ends all
    workers. If a worker is killed from outside, unfinished futures raise BrokenProcessPool."""

    def __init__(self, workers: int) -> None:
        if workers < 1:
            raise ValueError(f"workers must be 1 or more, got {workers}")
        self.workers = workers
        self.at_once = workers + 1  # calls submitted at a time: no worker waits, and few calls can be lost
        self._processes: ProcessPoolExecutor | None = None

    def submit(self, fn: Callable[..., Result], /, *args: Any, **kwargs: Any) -> Future[Result]:
        """Submit a call; with one worker, it is done when this method returns."""
        future: Future[Result] = Future()
        if self.workers == 1:
            try:
                future.set_result(fn(*args, **kwargs))
            except Exception as error:  # Ctrl-C ends this process
                future.set_exception(error)
            return future
        try:
            with one_thread_each():  # starts a process if none is idle, and initially a lock tracker
                if self._processes is None:
                    spawn = multiprocessing.get_context("spawn")
                    self._processes = ProcessPoolExecutor(self.workers, spawn, initializer=begin_worker)
                return self._processes.submit(fn, *args, **kwargs)
        except BrokenProcessPool as error:
            future.set_exception(error)
            return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the workers after all submitted calls, or after the current calls if `cancel_futures` is true."""
        if self._processes is not None:
            self._processes.shutdown(wait=wait, cancel_futures=cancel_futures)
        self._processes = None

    def terminate(self) -> None:
        """End all workers at once; recordings keep the data already written. `submit` then starts new ones."""
        if self._processes is not None:
            for process in list((self._processes._processes or {}).values()):
                process.terminate()
        self.shutdown(cancel_futures=True)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is None:
            self.shutdown()
        else:
            self.terminate()
