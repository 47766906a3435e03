"""The worker processes of comparisons, searches and studies."""

import multiprocessing
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from types import TracebackType
from typing import Any, TypeVar

from ecs_eco.experiments.workers import begin_worker, one_thread_each

Key = TypeVar("Key", bound=Hashable)
Result = TypeVar("Result")


class Pool(Executor):
    """An executor: workers of one thread each that end with this process;
    a single worker is this process itself.

    Only this process receives Ctrl-C: leaving the `with` block by an exception ends all workers. If a worker
    is killed from outside, all unfinished futures raise BrokenProcessPool.
    """

    def __init__(self, workers: int) -> None:
        if workers < 1:
            raise ValueError(f"workers must be 1 or more, got {workers}")
        self.workers = workers
        self._processes: ProcessPoolExecutor | None = None

    def submit(self, fn: Callable[..., Result], /, *args: Any, **kwargs: Any) -> Future[Result]:
        """Submit a call; with one worker it is done when this returns."""
        if self.workers == 1:
            return _done_here(fn, args, kwargs)
        try:
            with one_thread_each():  # a process is started if none is idle; first a tracker of locks
                if self._processes is None:
                    spawn = multiprocessing.get_context("spawn")
                    self._processes = ProcessPoolExecutor(self.workers, spawn, initializer=begin_worker)
                return self._processes.submit(fn, *args, **kwargs)
        except BrokenProcessPool as error:
            broken: Future[Result] = Future()
            broken.set_exception(error)
            return broken

    def completed(
        self, fn: Callable[..., Result], jobs: Mapping[Key, Sequence[Any]]
    ) -> Iterator[tuple[Key, Future[Result]]]:
        """Call `fn` with the arguments of each job; yield keys with their futures as these are done."""
        if min(self.workers, len(jobs)) == 1:
            for key, arguments in jobs.items():
                yield key, _done_here(fn, arguments, {})
            return
        keys = {self.submit(fn, *arguments): key for key, arguments in jobs.items()}
        for future in as_completed(keys):
            yield keys[future], future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the workers once they have finished what was submitted, or what they began."""
        if self._processes is not None:
            self._processes.shutdown(wait=wait, cancel_futures=cancel_futures)
        self._processes = None

    def terminate(self) -> None:
        """End all workers at once; recordings keep what they have. `submit` starts others."""
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


def _done_here(fn: Callable[..., Result], args: Sequence[Any], kwargs: Mapping[str, Any]) -> Future[Result]:
    """Do the work in this process; Ctrl-C ends it like anything here."""
    future: Future[Result] = Future()
    try:
        future.set_result(fn(*args, **kwargs))
    except Exception as error:
        future.set_exception(error)
    return future
