"""Calls on any executor, by key: submitted as capacity permits, and repeated if their worker was killed."""

import math
from collections import Counter, deque
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from typing import Any, Generic, NamedTuple, Self, TypeVar

from ecs_eco.lab.pool import Pool

RETRIES = 5  # how often a call whose worker was killed is repeated
Key = TypeVar("Key", bound=Hashable)
Item = TypeVar("Item")
Result = TypeVar("Result")


class Call(NamedTuple):
    """A function to be called with arguments, by its key."""

    key: Any
    fn: Callable[..., Any]
    arguments: tuple[Any, ...]


class Work(Generic[Key]):
    """Waiting and running calls of an executor; a context manager.

    Calls of the project's own Pool are repeated if their worker was killed, `retries` times at most (by
    default RETRIES); other executors do so themselves. Leaving `with` by an exception cancels all calls that
    have not begun.
    """

    def __init__(self, pool: Executor, retries: int | None = None) -> None:
        self.pool = pool
        self.retries = RETRIES if retries is None else retries
        self.waiting: deque[Call] = deque()
        self.running: dict[Future[Any], Call] = {}
        self.lost: Counter[Key] = Counter()  # how often the worker of a call was killed
        self.repeated = 0  # calls that were repeated

    def __len__(self) -> int:
        """Return how many calls wait or run."""
        return len(self.waiting) + len(self.running)

    def add(self, key: Key, fn: Callable[..., Any], *arguments: object) -> None:
        """Add a call, to be submitted as capacity permits."""
        self.waiting.append(Call(key, fn, arguments))

    def arrived(self, timeout: float | None = None) -> list[tuple[Key, Future[Any]]]:
        """Return the calls that finish within a time [s], or, if that is None, wait for the first."""
        self._submit()
        done, _ = wait(self.running, timeout, FIRST_COMPLETED)
        if isinstance(self.pool, Pool) and any(map(_lost_its_worker, done)):
            done, _ = wait(self.running)  # a pool that lost one worker loses all
            self.pool.terminate()
        arrived = [(future, self.running.pop(future)) for future in done]
        return [(call.key, future) for future, call in arrived if not self._again(call, future)]

    def stop(self) -> None:
        """End all calls; an executor that cannot end the running ones finishes them."""
        self.waiting.clear()
        for future in self.running:
            future.cancel()
        self.running.clear()
        if hasattr(self.pool, "terminate"):
            self.pool.terminate()

    def _submit(self) -> None:
        """Submit calls up to the capacity, or all if an executor has no limit."""
        room = getattr(self.pool, "at_once", None) or len(self)
        while self.waiting and len(self.running) < room:
            call = self.waiting.popleft()
            future = self.pool.submit(call.fn, *call.arguments)
            self.running[future] = call
            if future.done():
                return

    def _again(self, call: Call, future: Future[Any]) -> bool:
        """Repeat a call whose worker was killed, unless that happened too often."""
        if not isinstance(self.pool, Pool) or not _lost_its_worker(future):
            return False
        self.lost[call.key] += 1
        if self.lost[call.key] > self.retries:
            return False
        self.repeated += 1
        self.waiting.append(call)
        return True

    def __iter__(self) -> Iterator[tuple[Key, Future[Any]]]:
        """Yield keys with their futures as these are done, until none is left."""
        while len(self):
            yield from self.arrived()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None:
            for future in self.running:
                future.cancel()


def completed(
    pool: Executor, fn: Callable[..., Any], jobs: Mapping[Key, Sequence[Any]], retries: int | None = None
) -> Iterator[tuple[Key, Future[Any]]]:
    """Call `fn` with the arguments of each job; yield keys with their futures as these are done.

    A single job of a Pool is done in this process.
    """
    with Work[Key](Pool(1) if isinstance(pool, Pool) and len(jobs) == 1 else pool, retries) as work:
        for key, arguments in jobs.items():
            work.add(key, fn, *arguments)
        yield from work


def run_jobs(
    fn: Callable[..., Result],
    jobs: Mapping[Key, Sequence[Any]],
    pool: Executor,
    progress: Callable[[int, int], None],
    failed: Callable[[Key, BaseException], None],
    retries: int | None = None,
) -> dict[Key, Result]:
    """Call `fn` with the arguments of each job; return the results of those that succeeded.

    `progress` is called with the number of successes and of jobs, `failed` with a job and its exception; with
    BrokenExecutor, once, if a worker was killed from outside: then no other job is begun.
    """
    results: dict[Key, Result] = {}
    if not jobs:
        return results
    progress(0, len(jobs))
    for key, future in completed(pool, fn, jobs, retries):
        if (error := future.exception()) is None:
            results[key] = future.result()
        else:
            failed(key, error)
            if isinstance(error, BrokenExecutor):
                break
        progress(len(results), len(jobs))
    return results


def interleaved(groups: Sequence[Sequence[Item]]) -> list[Item]:
    """Return the items of groups in an order whose every beginning is as even over groups, and over
    positions in them, as possible: with groups of equal size neither differs by more than one."""
    n, most = len(groups), max(map(len, groups), default=0)
    again = math.lcm(n, most)  # from here on, positions would meet the same groups
    at = ((k % n, (k + k // again) % most) for k in range(n * most))
    return [groups[i][j] for i, j in at if j < len(groups[i])]


def _lost_its_worker(future: Future[Any]) -> bool:
    return not future.cancelled() and isinstance(future.exception(), BrokenExecutor)
