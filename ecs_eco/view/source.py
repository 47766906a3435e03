"""The interface between the viewer and a live world or a recorded run, and its messages."""

import json
from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeGuard

from ecs_eco.engine.errors import shortened

Message = dict[str, Any]


class Source(Protocol):
    """A source for the viewer, used in the thread that created it; docs/reference/viewer_protocol.md describes
    the messages."""

    @property
    def tick(self) -> int:
        """The displayed tick: the next tick of a live world, or the recorded tick whose end is shown."""

    @property
    def done(self) -> bool:
        """Whether this is the last tick."""

    def run(self, turn: Callable[[], bool]) -> None:
        """Run or show the world: call `turn()` before every tick and after the last one, until it returns False.
        It returns when the next tick is due; while `done`, only at the end, or if `seek` goes back."""

    def hello(self) -> Message:
        """Return the first message: {"kind": "hello", …}."""

    def greeting(self) -> list[Message]:
        """Return further messages that a new page needs after hello, such as `marks`."""

    def news(self) -> list[Message]:
        """Return new messages for all pages since the last call; must be fast if there are none."""

    def passed(self) -> None:
        """Update the source after a tick. Called before every tick, so it must be fast."""

    def counts(self) -> dict[str, int]:
        """Return the number of organisms or objects of each kind, for `state`."""

    def frame(self, number: int, colour: str) -> bytes:
        """Return the binary message for this tick: all organisms, colored by one of the `colours` of hello.
        Values from 1 to 255 span the range in `scales`; 0 means none or unknown."""

    def fates(self, after: int) -> Sequence[Sequence[float]]:
        """Return recent animal deaths after a tick: tick, species number, uid, position [m], killer's uid or 0."""

    def field(self, name: str) -> Message:
        """Return the map of one of the `fields` of hello: {"kind": "field", …}."""

    def scales(self, colour: str) -> dict[str, tuple[float, float]]:
        """Return the values shown as 1 and 255 in the last frame of this color, by species."""

    def sample(self) -> None:
        """Add a point to the series, unless the series is recorded. The player decides how often."""

    def series(self, after: int) -> Message | None:
        """Return the points after tick `after` (−1: all): {"kind": "series", …}; None if there are none."""

    def organism(self, uid: int) -> Message:
        """Return the message "organism", with everything known about it; raise KeyError if it never existed."""

    def handle(self, request: Message) -> list[Message]:
        """Carry out a request; return the answers for the requesting page. Refusals are `said` messages."""


def text(message: Message) -> str:
    """Return a message as JSON."""
    return json.dumps(message, separators=(",", ":"), allow_nan=False)


def said(level: str, words: str, field: str | None = None) -> Message:
    """Return a text at level "info", "warning" or "error"; `field` is the request that it refers to."""
    return {"kind": "said", "level": level, "text": words} | ({} if field is None else {"field": field})


def is_whole(value: object, low: int = 0, end: int = 2**63) -> TypeGuard[int]:
    """Return whether a value in a request is a whole number, at least `low` and less than `end`."""
    return isinstance(value, int) and not isinstance(value, bool) and low <= value < end


def uid_of(request: Message) -> int:
    """Return the uid in a request; raise ValueError if it has none."""
    uid = request.get("uid")
    if not is_whole(uid, 1):
        raise ValueError(f"{request['kind']}: uid = {short(uid)}; expected the uid of an organism")
    return uid


def short(value: object) -> str:
    """Return a value as JSON, shortened if it is long."""
    return shortened(json.dumps(value))
