"""Ensure that every change to a world is complete, or that the world is marked as unfinished: Ctrl-C takes
effect at the end of the tick, and an error leaves a mark."""

import importlib
import signal
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import Any

from esper import Processor

from ecs_eco.engine.errors import UnfinishedTick
from ecs_eco.engine.living import LivingWorld, Underway

# the `signal` module converts its results to enums, which takes longer than a tick of a small world
_signal: Any = importlib.import_module("_signal")
MAIN = threading.main_thread().ident


@contextmanager
def whole(world: LivingWorld, action: str) -> Iterator[None]:
    """A context for changing a world, which marks the world as unfinished if the change is not completed.

    Within another such context, this does nothing: the outer mark remains until the whole change is complete.
    """
    if world.underway is not None:
        yield
        return
    mark = world.underway = Underway(action)
    try:
        yield
    except BaseException as error:
        stopped(world, error)
        raise
    finally:
        mark.running = False
    world.underway = None


def stopped(world: LivingWorld, error: BaseException) -> None:
    """Record which error stopped the current action, and where."""
    if world.underway is not None and not world.underway.cause:
        world.underway.running = False
        message = " ".join(str(error).split())[:200]
        world.underway.cause = type(error).__name__ + (f": {message}" if message else "")
        world.underway.where = _where(error)


def require_whole(world: LivingWorld, wanted: str, within: bool = False) -> None:
    """Raise UnfinishedTick, naming the action `wanted`, if a world is unfinished; `within` allows the action
    during a tick."""
    mark = world.underway
    if mark is None or (within and mark.running):
        return
    if mark.running:
        raise RuntimeError(
            f"cannot {wanted} within a tick: {mark.text(world)} is in progress; wait until the tick ends"
        )
    by = f" ({mark.cause}{f' in {mark.where}' if mark.where else ''})" if mark.cause else ""
    raise UnfinishedTick(
        f"world {world.name!r}: cannot {wanted}: {mark.text(world)} began but did not finish{by}, "
        "so the state of the world is inconsistent. You can inspect it. Continue from a checkpoint, "
        "World.restore(path), or from an earlier copy, world.copy()"
    )


def _where(error: BaseException) -> str:
    """Return the name of the system that raised an error, or "" if there is none."""
    for frame, _ in traceback.walk_tb(error.__traceback__):
        owner = frame.f_locals.get("self")
        if isinstance(owner, Processor):
            return getattr(owner, "label", type(owner).__name__)
    return ""


class Patience:
    """Within this context, the first Ctrl-C takes effect at the end of the world's tick, and a second one
    immediately.

    This applies only in the main thread, and only if the user has not installed another handler.
    """

    def __init__(self, world: LivingWorld) -> None:
        self.world, self.interrupted, self.installed = world, False, False

    def __enter__(self) -> "Patience":
        if threading.get_ident() == MAIN and _signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            self.installed = True
            _signal.signal(signal.SIGINT, self._hear)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.installed:
            _signal.signal(signal.SIGINT, signal.default_int_handler)

    def _hear(self, number: int, frame: FrameType | None) -> None:
        if self.world.underway is None or self.interrupted:
            raise KeyboardInterrupt
        self.interrupted = True

    def over(self) -> None:
        """Raise KeyboardInterrupt if Ctrl-C was pressed during the tick that has just ended."""
        if self.interrupted:
            self.interrupted = False
            raise KeyboardInterrupt
