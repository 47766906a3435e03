"""The state of each page, its panel, and a log of the actions of all pages."""

import math
import threading
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from ecs_eco.config.models.interventions import describe
from ecs_eco.engine.errors import nearest, shortened
from ecs_eco.view.source import Message, Source, is_whole, said, short, text

FIELDS = 0.5  # [s] between maps of a field


class Page(Protocol):
    """The server side of one page."""

    def send(self, messages: list[str | bytes]) -> None:
        """Queue messages and return immediately."""


class View:
    """The choices made on one page, and the data sent to it."""

    def __init__(self) -> None:
        self.number = 0  # pages are numbered in the order in which they join
        self.colour = "species"
        self.selected: tuple[int, bool] | None = None  # uid, and whether it belongs to the second world
        self.awaits: int | None = None  # number of the frame not yet acknowledged
        self.seen: tuple[Any, ...] | None = None  # contents of the last frame
        self.frame_at = self.panel_at = self.field_at = -math.inf
        self.series = -1  # last tick of the series sent
        self.panel: tuple[Any, ...] | None = None  # contents of the last panel
        self.news, self.sent_tick = True, -1  # whether to send the state; the last tick sent
        self.fated = -1  # the last tick whose deaths were sent
        self.field: str | None = None  # the field laid over the scene
        self.mapped: tuple[Any, ...] | None = None  # contents of the last map
        self.panels: dict[str, Message | None] = {}  # users' panels on this page, and what was last sent

    def back(self, tick: int) -> None:
        """Discard the data already sent for this tick and later ticks."""
        self.series, self.seen, self.panel = min(self.series, tick - 1), None, None
        self.fated, self.mapped = min(self.fated, tick - 1), None

    def whole(self, tick: int) -> bool:
        """Return whether the page has everything for a tick."""
        return (
            self.seen == (tick, self.colour)
            and (self.selected is None or self.panel == (tick, self.selected))
            and (self.field is None or self.mapped == (tick, self.field))
        )

    def lay(self, source: Source, request: Message) -> None:
        """Choose the field laid over the scene (null: none)."""
        name, known = request.get("name"), source.hello().get("fields", [])
        if name is not None and name not in known:
            raise ValueError(
                f"field: name = {short(name)}; expected {', '.join(known) or 'null'}"
                + (f"; did you mean {nearest(name, known)!r}?" if known else "")
            )
        self.field, self.mapped, self.field_at = name, None, -math.inf


def beside(source: Source, view: View, now: float, out: list[str | bytes]) -> None:
    """Add the messages that accompany a frame: deaths since the last frame, and the map of a field."""
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
    """A queue of messages from pages; `say` and `close` may be called from any thread."""

    def __init__(self) -> None:
        self.inbox: deque[tuple[Page, Message]] = deque()
        self.closing = False
        self._wake = threading.Event()

    def say(self, page: Page, request: Message) -> None:
        """Deliver a page's message {"kind": …}; "join" and "leave" mark its presence."""
        self.inbox.append((page, request))
        self._wake.set()

    def close(self) -> None:
        """Stop serving the pages."""
        self.closing = True
        self._wake.set()


def choose(source: Source, view: View, request: Message) -> None:
    """Select an organism by its uid (null: none), in the second world if `second` is true."""
    uid, second = request.get("uid"), request.get("second", False)
    if uid is not None and not is_whole(uid, 1):
        raise ValueError(f"select: uid = {short(uid)}; expected the uid of an organism, or null")
    if not isinstance(second, bool):
        raise ValueError(f"select: second = {short(second)}; expected true or false")
    if second and uid is not None and _second(source) is None:
        raise ValueError(f"select: #{uid} belongs to a second world, but no second world is shown")
    view.selected, view.panel, view.panel_at = None if uid is None else (uid, second), None, -math.inf


def panel(source: Source, view: View, now: float, out: list[str | bytes]) -> None:
    """Add the state of the selected organism, or an error if it is unknown."""
    assert view.selected is not None
    view.panel_at, view.panel = now, (source.tick, view.selected)
    uid, second = view.selected
    known = _second(source) if second else source
    if known is None:  # pages already know that the second world is closed
        view.selected = None
        return
    try:
        out.append(text(known.organism(uid)))
    except Exception as error:  # an error in a panel must not end the run
        problem = f"organism {uid}: {type(error).__name__}: {error}"
        words = f"no organism {uid} is known here" if isinstance(error, KeyError) else problem
        out.append(text(said("error", words, "select")))
        view.selected = None


def _second(source: Source) -> Any:
    """Return the second world next to a source, or None."""
    return getattr(source, "second", None)


KEPT = 200  # maximum number of entries; older entries are dropped
LONGEST = 400  # maximum number of characters per entry
DOES = ("act", "seek", "whatif", "begin")  # requests that are logged


class Log:
    """The last KEPT actions of pages and the answers to them. `views` are the connected pages; if `used` is
    false, as for a recorded run, the log only numbers them in the order in which they join."""

    def __init__(self, views: Mapping[Page, View], used: bool) -> None:
        self.views, self.used = views, used
        self.entries: deque[Message] = deque(maxlen=KEPT)
        self._came = 0

    def came(self, view: View) -> list[Message]:
        """Give a new page its number; return all entries so far."""
        self._came += 1
        view.number = self._came
        return [{"kind": "log", "page": view.number, "entries": list(self.entries)}] if self.used else []

    def answered(self, tick: int, view: View, request: Message, answers: Sequence[Message]) -> None:
        """Log a page's request at a tick with the answers, and send the entries to all pages."""
        if request.get("kind") in DOES:
            for answer in answers:
                self._note(tick, answer, {"page": view.number, **_of(request)})

    def told(self, tick: int, messages: Sequence[Message]) -> list[Message]:
        """Log messages that go to all pages; return them as a list."""
        for message in messages:
            self._note(tick, message, {"page": None})
        return list(messages)

    def _note(self, tick: int, answer: Message, who: Message) -> None:
        if not self.used or answer["kind"] != "said":
            return
        words = str(answer["text"]).removeprefix(f"tick {tick}: ")
        entry = {"tick": tick, "level": answer["level"], "text": shortened(words, LONGEST), **who}
        self.entries.append(entry)
        for page in self.views:
            page.send([text({"kind": "log", "entries": [entry]})])


def _of(request: Message) -> dict[str, Any]:
    """Return a request's description, and whether it undoes an earlier request."""
    what, way = request.get("what"), request.get("as")
    try:
        words = describe(what) if isinstance(what, dict) else ""
    except (KeyError, TypeError, ValueError, AttributeError):  # not an intervention
        words = ""
    undoes = {"as": way} if way in ("undo", "reset") else {}
    return {"asked": request["kind"], "what": shortened(words, LONGEST)} | undoes
