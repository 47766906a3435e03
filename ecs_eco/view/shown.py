"""What one page shows, asks, and is sent beside frames: deaths to be marked, and a field over the scene."""

from __future__ import annotations

import math
import threading
from collections import deque
from typing import Any, NamedTuple, Protocol

from ecs_eco.engine.errors import nearest
from ecs_eco.view.messages import short, text
from ecs_eco.view.source import Message, Source

FIELDS = 0.5  # [s] from one map of a field to the next


class Page(Protocol):
    """The server's end of one page."""

    def send(self, messages: list[str | bytes]) -> None:
        """Queue messages; returns at once."""


class Chosen(NamedTuple):
    """A selected organism: its uid, and whether it is one of the second world."""

    uid: int
    second: bool = False


class View:
    """What one page shows, and what it has been sent."""

    def __init__(self) -> None:
        self.number = 0  # of the page, in the order of coming
        self.colour = "species"
        self.selected: Chosen | None = None
        self.awaits: int | None = None  # the frame that it has not acknowledged yet
        self.seen: tuple[Any, ...] | None = None  # what its last frame showed
        self.frame_at = self.panel_at = self.field_at = -math.inf
        self.series = -1  # last tick of the series that it has
        self.panel: tuple[Any, ...] | None = None  # what its last panel showed
        self.news, self.sent_tick = True, -1  # whether the state is to be sent; the tick that was sent last
        self.fated = -1  # the tick up to which it knows who has died
        self.field: str | None = None  # that lies over its scene
        self.mapped: tuple[Any, ...] | None = None  # what its last map showed

    def back(self, tick: int) -> None:
        """Forget what was sent of ticks from this one on."""
        self.series, self.seen, self.panel = min(self.series, tick - 1), None, None
        self.fated, self.mapped = min(self.fated, tick - 1), None

    def whole(self, tick: int) -> bool:
        """Whether the page has all of a tick."""
        return (
            self.seen == (tick, self.colour)
            and (self.selected is None or self.panel == (tick, self.selected))
            and (self.field is None or self.mapped == (tick, self.field))
        )

    def lay(self, source: Source, request: Message) -> None:
        """Choose the field that lies over the scene, None for none."""
        name, known = request.get("name"), source.hello().get("fields", [])
        if name is not None and name not in known:
            raise ValueError(
                f"field: name = {short(name)}; allowed: {', '.join(known) or 'null alone'}"
                + (f"; did you mean {nearest(name, known)!r}?" if known else "")
            )
        self.field, self.mapped, self.field_at = name, None, -math.inf


def beside(source: Source, view: View, now: float, out: list[str | bytes]) -> None:
    """Add what a page lacks beside its frame: deaths since the last one, and the map of a field."""
    tick = source.tick
    if view.fated != tick and view.seen is not None and view.seen[0] == tick:
        fates = source.fates(view.fated if view.fated < tick else -1)
        view.fated = tick
        if fates:
            out.append(text({"kind": "fates", "list": fates}))
    if view.field is not None and view.mapped != (tick, view.field) and now >= view.field_at + FIELDS:
        view.field_at, view.mapped = now, (tick, view.field)
        out.append(text(source.field(view.field)))


class Inbox:
    """Messages of pages that wait for an answer; `say` and `close` may be called from any thread."""

    def __init__(self) -> None:
        self.inbox: deque[tuple[Page, Message]] = deque()
        self.closing = False
        self._wake = threading.Event()

    def say(self, page: Page, request: Message) -> None:
        """Deliver a page's message: {"kind": …}; "join" and "leave" mark its presence."""
        self.inbox.append((page, request))
        self._wake.set()

    def close(self) -> None:
        """End what serves the pages."""
        self.closing = True
        self._wake.set()
