"""Signals that stop a run after a whole tick."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ecs_eco.ecosystem import World


@contextmanager
def stopping(world: World) -> Iterator[Callable[[], None]]:
    """Let SIGINT and SIGTERM stop the world at the end of its tick; the second one stops at once.

    Lends a function to be called afterwards where the world had come to its end anyway: it passes the signals
    on to handlers that others had installed, such as a worker's that is told to end.
    """
    world.stopping = world.stopped = False
    if threading.current_thread() is not threading.main_thread():
        yield lambda: None
        return

    heard: list[signal.Signals] = []

    def pass_on() -> None:
        for number in heard:
            if callable(before[number]) and before[number] is not signal.default_int_handler:
                signal.raise_signal(number)

    def stop(number: int, frame: Any) -> None:
        heard.append(signal.Signals(number))
        if world.stopping:
            raise KeyboardInterrupt
        world.stop()

    before: dict[signal.Signals, Any] = {}
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            before[number] = signal.signal(number, stop)
    try:
        yield pass_on
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
