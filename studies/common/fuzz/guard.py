"""A guard for calls that may hang or crash."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from typing import Any


def guarded(
    judge: Callable[[Any], dict[str, Any]], items: Sequence[Any], seconds: float, memory: int = 4 << 30
) -> Iterator[dict[str, Any]]:
    """Return judge(item) for each item, computed in a child process: "hang" after the time limit, "crash" if
    the child died."""
    context, at = multiprocessing.get_context("fork"), 0
    while at < len(items):
        ours, theirs = context.Pipe(duplex=False)
        child = context.Process(target=_child, args=(judge, items[at:], theirs, memory), daemon=True)
        child.start()
        theirs.close()
        while at < len(items):
            try:
                outcome = ours.recv() if ours.poll(seconds) else {"kind": "hang"}
            except EOFError:
                outcome = {"kind": "crash"}
            at += 1
            yield outcome
            if outcome["kind"] in ("hang", "crash"):
                break
        child.kill()
        child.join()
        ours.close()


def _child(judge: Callable[[Any], dict[str, Any]], items: Sequence[Any], pipe: Any, memory: int) -> None:
    import resource
    import warnings

    with open("/proc/self/statm", encoding="ascii") as file:
        have = int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (have + memory, have + memory))
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    warnings.simplefilter("error")
    for item in items:
        pipe.send(judge(item))
