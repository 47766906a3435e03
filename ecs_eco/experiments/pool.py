"""Who evaluates candidates: processes of one thread each, or, for one worker, this one."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from typing import Any

from ecs_eco.experiments.workers import end_with_parent, one_thread_each


class Alone:
    """No process but this one: it does its work when its result is asked for. Ctrl-C ends it like anything here."""

    workers = 1

    def __init__(self) -> None:
        self.running: list[tuple[Any, Callable[..., Any], tuple[Any, ...]]] = []

    @property
    def free(self) -> int:
        """Whether there is nothing to do."""
        return 1 - len(self.running)

    def submit(self, tag: Any, work: Callable[..., Any], *arguments: Any) -> None:
        """Remember what is to be done."""
        self.running.append((tag, work, arguments))

    def results(self, timeout: float | None = None) -> Iterator[tuple[Any, Any]]:
        """Do it: (tag, result)."""
        while self.running:
            tag, work, arguments = self.running.pop()
            yield tag, work(*arguments)

    def stop(self) -> None:
        """Forget what was not begun."""
        self.running.clear()


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
        with one_thread_each():  # processes start with the first that is submitted
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
    end_with_parent()

