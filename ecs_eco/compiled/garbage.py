"""Control of Python's cyclic garbage collector.

By default, it runs after every 700 new objects, and over all objects when their number has grown by a
quarter. This takes a tenth of the time that a command needs to load its modules, and as long again at exit.
The effort is wasted, because these objects exist until the process ends.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

SELDOM = 20_000  # number of new objects between two collections while modules are loaded
_usual: list[tuple[int, int, int]] = []


@contextmanager
def uncollected() -> Iterator[None]:
    """Disable the collector within this context, for work that creates many long-lived objects."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.enable()


@contextmanager
def of_a_command() -> Iterator[None]:
    """Speed up the start and the end of a process: collect rarely until `loaded` is called, and not at all at
    the end. The process must end after this context."""
    _usual.append(gc.get_threshold())
    gc.set_threshold(SELDOM)
    try:
        yield
    finally:
        gc.freeze()


def loaded() -> None:
    """Resume normal collection, excluding the current objects; do nothing outside a command's own process."""
    if _usual:
        gc.freeze()
        gc.set_threshold(*_usual.pop())
        gc.enable()
