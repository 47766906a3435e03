"""Signals that stop a run after a whole tick."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ecs_eco.ecosystem import World


@contextmanager
def stopping(world: World) -> Iterator[None]:
    """Let SIGINT and SIGTERM stop the world at the end of its tick; the second one stops at once."""
    world.stopping = world.stopped = False
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(number: int, frame: Any) -> None:
        if world.stopping:
            raise KeyboardInterrupt
        world.stop()

    before = {}
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            before[number] = signal.signal(number, stop)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
