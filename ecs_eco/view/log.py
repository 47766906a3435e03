"""One log for all pages of a living world: what any of them did, and what was answered."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

from ecs_eco.view.messages import text
from ecs_eco.view.shown import Page, View
from ecs_eco.view.source import Message

KEPT = 200  # entries; older ones are forgotten
LONGEST = 400  # letters of one
DOES = ("act", "seek", "whatif", "begin")  # requests that are noted


class Log:
    """What pages did and were told, the last KEPT entries; each page has a number, in the order of coming.

    `views` are the pages that there are. Not `used`, for a recorded run, it numbers pages and notes nothing.
    """

    def __init__(self, views: Mapping[Page, View], used: bool) -> None:
        self.views, self.used = views, used
        self.entries: deque[Message] = deque(maxlen=KEPT)
        self._came = 0

    def came(self, view: View) -> list[Message]:
        """Give a new page its number; return all that was noted so far."""
        self._came += 1
        view.number = self._came
        return [{"kind": "log", "page": view.number, "entries": list(self.entries)}] if self.used else []

    def answered(self, tick: int, view: View, request: Message, answers: Sequence[Message]) -> None:
        """Note what a page asked for at a tick and was told, and tell all pages."""
        if request.get("kind") in DOES:
            for answer in answers:
                self._note(tick, answer, {"page": view.number, **_of(request)})

    def refused(self, tick: int, view: View, request: Message, words: str) -> None:
        """Note that a page was refused what it asked for."""
        self.answered(tick, view, request, [{"kind": "said", "level": "error", "text": words}])

    def told(self, tick: int, messages: Sequence[Message]) -> list[Message]:
        """Note what all pages are told; return all that they are to be sent."""
        for message in messages:
            self._note(tick, message, {"page": None})
        return list(messages)

    def _note(self, tick: int, answer: Message, who: Message) -> None:
        if not self.used or answer["kind"] != "said":
            return
        words = str(answer["text"]).removeprefix(f"tick {tick}: ")
        entry = {"tick": tick, "level": answer["level"], "text": _cut(words), **who}
        self.entries.append(entry)
        for page in self.views:
            page.send([text({"kind": "log", "entries": [entry]})])


def _of(request: Message) -> dict[str, Any]:
    """Return what was asked for, in words, and whether it takes something back."""
    from ecs_eco.config.models.interventions import describe

    what, way = request.get("what"), request.get("as")
    try:
        words = describe(what) if isinstance(what, dict) else ""
    except (KeyError, TypeError, ValueError, AttributeError):  # it is no intervention
        words = ""
    return {"asked": request["kind"], "what": _cut(words)} | ({"as": way} if way in ("undo", "reset") else {})


def _cut(words: str) -> str:
    return words if len(words) <= LONGEST else words[: LONGEST - 1] + "…"
