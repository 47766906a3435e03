"""Processes of one thread each that evaluate candidates."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from typing import Any

PINS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class Pool:
    """So many workers, each with at most one piece of work; `results` hands out what is done."""

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self.running: dict[Future[Any], Any] = {}
        self._pool: ProcessPoolExecutor | None = None

    @property
    def free(self) -> int:
        """Workers with nothing to do."""
        return self.workers - len(self.running)

    def submit(self, tag: Any, work: Callable[..., Any], *arguments: Any) -> None:
        """Let a worker do it."""
        with _pinned():  # processes start with the first that is submitted
            if self._pool is None:
                self._pool = ProcessPoolExecutor(self.workers, multiprocessing.get_context("spawn"), initializer=_leave_ctrl_c)
            self.running[self._pool.submit(work, *arguments)] = tag

    def results(self, timeout: float | None = None) -> Iterator[tuple[Any, Any]]:
        """What is done by now, or first: (tag, result); nothing after `timeout` seconds. Raises what a worker raised."""
        done, _ = wait(self.running, timeout, FIRST_COMPLETED)
        for future in done:
            yield self.running.pop(future), future.result()

    def stop(self) -> None:
        """End all workers, whatever they do."""
        if self._pool is not None:
            for process in list((self._pool._processes or {}).values()):
                process.terminate()
            self._pool.shutdown(wait=True, cancel_futures=True)
        self._pool, self.running = None, {}


def _leave_ctrl_c() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends its workers


@contextmanager
def _pinned() -> Iterator[None]:
    """Processes that start within use one thread each."""
    before = {name: os.environ.get(name) for name in PINS}
    os.environ.update(dict.fromkeys(PINS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
