"""A change of the world is whole, or the world says that it is not: Ctrl-C waits for the end of the tick, an error leaves a mark."""

import importlib
import signal
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any

import esper

from ecs_eco.engine.errors import UnfinishedTick
from ecs_eco.engine.flushes import Births, Deaths

_signal: Any = importlib.import_module("_signal")  # `signal` makes enums of all it returns, which takes longer than a small tick
MAIN = threading.main_thread().ident
FLUSHES: dict[type, str] = {Deaths: "the deaths of the phase die", Births: "the births of the phase reproduce"}


class Underway:
    """What is being done to a world that must be done as a whole; `world.underway` holds it until it is done.

    Nothing that stops it in the middle can take the mark away: it is set before the first change, and removed after the last.
    """

    def __init__(self, what: str, running: bool = True) -> None:
        self.what, self.running = what, running
        self.where, self.cause = "", ""

    def said(self, world: Any) -> str:
        """What it is, for messages."""
        return f"tick {world.tick}" if self.what == "tick" else self.what


@contextmanager
def whole(world: Any, what: str) -> Iterator[None]:
    """Within it a world is changed; where that does not come to its end, the world is no longer whole, and says so.

    Within another such change it adds nothing: that one's mark stands until all is done.
    """
    if world.underway is not None:
        yield
        return
    mark = world.underway = Underway(what)
    try:
        yield
    except BaseException as error:
        stopped(world, error)
        raise
    finally:
        mark.running = False
    world.underway = None


def stopped(world: Any, error: BaseException) -> None:
    """Note what stopped what was under way, and where."""
    if world.underway is not None and not world.underway.cause:
        world.underway.running = False
        message = " ".join(str(error).split())[:200]
        world.underway.cause = type(error).__name__ + (f": {message}" if message else "")
        world.underway.where = _where(error)


def require_whole(world: Any, wanted: str, within: bool = False) -> None:
    """Raise UnfinishedTick where a world cannot be used for what is `wanted`; `within`: whether it may be in a tick that goes on."""
    mark = world.underway
    if mark is None or (within and mark.running):
        return
    if mark.running:
        raise RuntimeError(f"cannot {wanted} within a tick: {mark.said(world)} is under way; do it between two ticks")
    by = f" ({mark.cause}{f' in {mark.where}' if mark.where else ''})" if mark.cause else ""
    raise UnfinishedTick(
        f"world {world.name!r}: cannot {wanted}: {mark.said(world)} began and did not end{by}, so the world is neither what it was nor "
        "what it was to be. It may still be looked at. Go on from a checkpoint, World.restore(path), or from a copy that was made "
        "before, world.copy()"
    )


def _where(error: BaseException) -> str:
    """Return the system in whose turn an error arose, "" where it was in none's."""
    for frame, _ in traceback.walk_tb(error.__traceback__):
        owner = frame.f_locals.get("self")
        if isinstance(owner, esper.Processor):
            return FLUSHES.get(type(owner), type(owner).__name__)
    return ""


class Patience:
    """While a world runs in the main thread, the first Ctrl-C waits for the end of its tick; the second one does not.

    Takes the place of Python's own handler only: whoever has set another one is asked as before.
    """

    def __init__(self, world: Any) -> None:
        self.world, self.asked, self.mine = world, False, False

    def __enter__(self) -> "Patience":
        if threading.get_ident() == MAIN and _signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            self.mine = True
            _signal.signal(signal.SIGINT, self._hear)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self.mine:
            _signal.signal(signal.SIGINT, signal.default_int_handler)

    def _hear(self, number: int, frame: Any) -> None:
        if self.world.underway is None or self.asked:
            raise KeyboardInterrupt
        self.asked = True

    def over(self) -> None:
        """Raise KeyboardInterrupt where Ctrl-C was pressed in the tick that is over now."""
        if self.asked:
            self.asked = False
            raise KeyboardInterrupt
