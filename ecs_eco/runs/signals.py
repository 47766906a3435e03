"""Signals that stop a run after a complete tick."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ecs_eco.ecosystem import World


@contextmanager
def stopping(world: World) -> Iterator[Callable[[], None]]:
    """Make SIGINT and SIGTERM stop the world at the end of its tick; a second signal stops it at once.

    Yields a function to call afterward if the world had already ended: it passes the signals on to previously
    installed handlers, such as the handler that ends a worker.
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

    def stop(number: int, frame: object) -> None:
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
