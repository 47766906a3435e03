"""Threads for matrix products; their number affects speed, never results.

torch and BLAS split products among their threads, and sums that are split differently differ in their last
bits. Each product that affects results is therefore computed by a single thread; the user's settings of torch
and BLAS are restored afterward.
"""

import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager, nullcontext
from functools import lru_cache

# BLAS has one thread count per process: two callers that change it at once would restore the wrong count
_blas = threading.RLock()


@contextmanager
def one_torch_thread() -> Iterator[None]:
    """Restrict torch to the calling thread within this context, then restore its setting."""
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        if threads != 1:
            torch.set_num_threads(threads)


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Restrict the linear algebra of numpy and scipy to the calling thread within this context, then
    restore its setting."""
    from threadpoolctl import threadpool_limits

    with _blas, threadpool_limits(1, "blas"):
        yield


def in_parallel(work: Callable[[int], None], workers: int) -> None:
    """Call work(0) … work(workers - 1), each in its own thread with one torch thread; return when all calls
    have ended."""
    if workers == 1:
        with one_torch_thread() if "torch" in sys.modules else nullcontext():
            work(0)
        return
    pool = _pool(workers)
    calls = [pool.submit(work, worker) for worker in range(workers)]
    try:
        wait(calls)
    except BaseException:  # Ctrl-C: the calls still write to their buffers
        wait(calls)
        raise
    for call in calls:
        call.result()


@lru_cache(maxsize=1)
def _pool(workers: int) -> ThreadPoolExecutor:
    """Return threads with one torch thread each, independent of torch's setting elsewhere."""
    import torch

    threads, all_there = torch.get_num_threads(), threading.Barrier(workers)

    def settle(_: int) -> None:
        # torch applies the number last set in any thread to a new thread only once, at that thread's first
        # query or large product; without this query, it would replace our number then
        torch.get_num_threads()
        torch.set_num_threads(1)
        all_there.wait()  # so that each thread in the pool gets one of these calls

    pool = ThreadPoolExecutor(workers, "ecs-eco-brain")
    try:
        list(pool.map(settle, range(workers)))
    except BaseException:
        all_there.abort()
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    finally:
        torch.set_num_threads(threads)  # also sets the number for threads that are started later
    return pool
