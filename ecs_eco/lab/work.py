"""Calls on any executor, by key: submitted as capacity permits, and repeated if their worker is killed."""

import math
from collections import Counter, deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from typing import Any, Generic, Self, TypeVar

from ecs_eco.lab.pool import Pool

RETRIES = 5  # how often a call is repeated if its worker is killed
Key = TypeVar("Key", bound=Hashable)
Item = TypeVar("Item")


Call = tuple[Any, Callable[..., Any], tuple[Any, ...]]  # a key, a function and its arguments


class Work(Generic[Key]):
    """The waiting and running calls of an executor, as a context manager. A `Pool`'s calls are repeated if their
    worker is killed, at most `retries` times (default: RETRIES); other executors repeat calls themselves. An
    exception that leaves the `with` block cancels all calls that have not begun."""

    def __init__(self, pool: Executor, retries: int | None = None) -> None:
        self.pool = pool
        self.retries = RETRIES if retries is None else retries
        self.waiting: deque[Call] = deque()
        self.blocked: dict[Hashable, list[Call]] = {}  # by the key of the call that they wait for
        self.running: dict[Future[Any], Call] = {}
        self.lost: Counter[Key] = Counter()  # how often a call's worker was killed
        self.repeated = 0  # number of repeated calls

    def __len__(self) -> int:
        return len(self.waiting) + len(self.running)

    def add(self, key: Key, fn: Callable[..., Any], *arguments: object, after: Hashable = None) -> None:
        """Add a call, to be submitted as capacity permits, or once the call with the key `after` has succeeded; if
        that one fails, so does this one, with the same future."""
        (self.waiting if after is None else self.blocked.setdefault(after, [])).append((key, fn, arguments))

    def arrived(self, timeout: float | None = None) -> list[tuple[Key, Future[Any]]]:
        """Return the calls that finish within `timeout` [s]; if it is None, wait for the first."""
        self._submit()
        done, _ = wait(self.running, timeout, FIRST_COMPLETED)
        if isinstance(self.pool, Pool) and any(map(_lost_its_worker, done)):
            done, _ = wait(self.running)  # a pool that loses one worker loses all its workers
            self.pool.terminate()
        arrived = [(future, self.running.pop(future)) for future in done]
        ended = [(call[0], future) for future, call in arrived if not self._again(call, future)]
        for key, future in ended:  # grows by the calls that waited for a failed one
            freed = self.blocked.pop(key, [])
            if future.cancelled() or future.exception() is not None:
                ended += [(call[0], future) for call in freed]
            else:
                self.waiting += freed
        return ended

    def stop(self) -> None:
        """End all calls; an executor that cannot end running calls finishes them."""
        self.waiting.clear()
        self.blocked.clear()
        for future in self.running:
            future.cancel()
        self.running.clear()
        if hasattr(self.pool, "terminate"):
            self.pool.terminate()

    def _submit(self) -> None:
        """Submit calls up to the executor's capacity, or all if it has no limit."""
        room = getattr(self.pool, "at_once", None) or len(self)
        while self.waiting and len(self.running) < room:
            key, fn, arguments = self.waiting.popleft()
            future = self.pool.submit(fn, *arguments)
            self.running[future] = key, fn, arguments
            if future.done():
                return

    def _again(self, call: Call, future: Future[Any]) -> bool:
        """Repeat a call whose worker was killed, unless this happened too often; return whether it is repeated."""
        if not isinstance(self.pool, Pool) or not _lost_its_worker(future):
            return False
        key, *_ = call
        self.lost[key] += 1
        if self.lost[key] > self.retries:
            return False
        self.repeated += 1
        self.waiting.append(call)
        return True

    def __iter__(self) -> Iterator[tuple[Key, Future[Any]]]:
        """Yield keys with their futures as they complete, until no call is left."""
        while len(self):
            yield from self.arrived()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None:
            for future in self.running:
                future.cancel()


def completed(
    pool: Executor,
    calls: Mapping[Key, Sequence[Any]],
    retries: int | None = None,
    after: Mapping[Key, Key] | None = None,
) -> Iterator[tuple[Key, Future[Any]]]:
    """Make calls, each a function and its arguments; yield keys with their futures as they complete. A call with
    an entry in `after` waits for the call with that key. On a Pool, a single call runs in this process."""
    with Work[Key](Pool(1) if isinstance(pool, Pool) and len(calls) == 1 else pool, retries) as work:
        for key, (fn, *arguments) in calls.items():
            work.add(key, fn, *arguments, after=(after or {}).get(key))
        yield from work


def run_jobs(
    calls: Mapping[Key, Sequence[Any]],
    pool: Executor,
    progress: Callable[[int, int], None],
    failed: Callable[[Key, BaseException], None],
    retries: int | None = None,
    after: Mapping[Key, Key] | None = None,
) -> dict[Key, Any]:
    """Make calls as `completed` does; return the results of those that succeeded. `progress` is called with the
    numbers of successes and of calls, `failed` with a key and its exception. If a worker is killed from
    outside, `failed` is called once with a BrokenExecutor, and no further call is started."""
    results: dict[Key, Any] = {}
    if not calls:
        return results
    progress(0, len(calls))
    for key, future in completed(pool, calls, retries, after):
        if (error := future.exception()) is None:
            results[key] = future.result()
        else:
            failed(key, error)
            if isinstance(error, BrokenExecutor):
                break
        progress(len(results), len(calls))
    return results


def interleaved(groups: Sequence[Sequence[Item]]) -> list[Item]:
    """Return the items of groups, ordered so that at every point, groups and positions within groups have
    advanced as evenly as possible; for groups of equal size, counts differ by at most one."""
    n, most = len(groups), max(map(len, groups), default=0)
    again = math.lcm(n, most)  # after this many items, the same pairs of group and position would recur
    at = ((k % n, (k + k // again) % most) for k in range(n * most))
    return [groups[i][j] for i, j in at if j < len(groups[i])]


def group(items: Iterable[Item], of: Callable[[Item], Any]) -> dict[Any, list[Item]]:
    """Group items by the result of a function, keeping their order."""
    parts: dict[Any, list[Item]] = {}
    for item in items:
        parts.setdefault(of(item), []).append(item)
    return parts


def evenly(items: Iterable[Item], *keys: Callable[[Item], Hashable]) -> list[Item]:
    """Return items ordered so that groups with equal keys advance evenly: by the first key, and within its
    groups by the next."""
    if not keys:
        return list(items)
    return interleaved([evenly(own, *keys[1:]) for own in group(items, keys[0]).values()])


def _lost_its_worker(future: Future[Any]) -> bool:
    return not future.cancelled() and isinstance(future.exception(), BrokenExecutor)
