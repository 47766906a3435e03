"""When Python looks for circles of objects that nothing else refers to.

It does so after every 700 objects more, and among all that there are when these have become a quarter more.
While a command loads its modules that is a tenth of the time, and at its end, when it takes all of them
apart, as much again: for nothing, since they stay until the process ends.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

SELDOM = 20_000  # objects more between two looks, while modules load
_usual: list[tuple[int, int, int]] = []


@contextmanager
def uncollected() -> Iterator[None]:
    """Within, Python does not look for circles: for work that makes many objects which stay."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.enable()


@contextmanager
def of_a_command() -> Iterator[None]:
    """Within, a process begins and ends quickly: it looks for circles seldom until `loaded`, and not at all
    among what is there at its end. Not for processes that go on afterwards."""
    _usual.append(gc.get_threshold())
    gc.set_threshold(SELDOM)
    try:
        yield
    finally:
        gc.freeze()


def loaded() -> None:
    """Go on as usual, without what there is now; does nothing outside of a command of its own process."""
    if _usual:
        gc.freeze()
        gc.set_threshold(*_usual.pop())
        gc.enable()
