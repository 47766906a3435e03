"""Changes of a world are completed or marked: Ctrl-C waits for the end of the tick, an error leaves a mark."""

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

# `signal` makes enums of all it returns, which takes longer than a small tick
_signal: Any = importlib.import_module("_signal")
MAIN = threading.main_thread().ident


@contextmanager
def whole(world: LivingWorld, action: str) -> Iterator[None]:
    """Change a world in this context; if the change does not complete, the world is marked as unfinished.

    Nested in another such context it does nothing: the outer mark stands until all is done.
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
    """Note which error stopped the action under way, and where."""
    if world.underway is not None and not world.underway.cause:
        world.underway.running = False
        message = " ".join(str(error).split())[:200]
        world.underway.cause = type(error).__name__ + (f": {message}" if message else "")
        world.underway.where = _where(error)


def require_whole(world: LivingWorld, wanted: str, within: bool = False) -> None:
    """Raise UnfinishedTick if an unfinished world cannot do what is `wanted`; `within` a running tick it may."""
    mark = world.underway
    if mark is None or (within and mark.running):
        return
    if mark.running:
        raise RuntimeError(
            f"cannot {wanted} within a tick: {mark.text(world)} is under way; do it between two ticks"
        )
    by = f" ({mark.cause}{f' in {mark.where}' if mark.where else ''})" if mark.cause else ""
    raise UnfinishedTick(
        f"world {world.name!r}: cannot {wanted}: {mark.text(world)} began and did not end{by}, "
        "so the world is neither what it was nor what it was to be. It may still be looked at. "
        "Go on from a checkpoint, World.restore(path), or from a copy that was made before, world.copy()"
    )


def _where(error: BaseException) -> str:
    """Return the name of the system that was running when an error arose, "" if none was."""
    for frame, _ in traceback.walk_tb(error.__traceback__):
        owner = frame.f_locals.get("self")
        if isinstance(owner, Processor):
            return getattr(owner, "label", type(owner).__name__)
    return ""


class Patience:
    """While a world runs in the main thread, the first Ctrl-C waits for the end of its tick;
    the second one does not.

    It replaces Python's default handler only: a handler that the user has installed is left in place.
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
        """Raise KeyboardInterrupt where Ctrl-C was pressed in the tick that is over now."""
        if self.interrupted:
            self.interrupted = False
            raise KeyboardInterrupt
