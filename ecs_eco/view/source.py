"""What a viewer shows: the one interface of a world that lives and of a run that was recorded."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

Message = dict[str, Any]


class Source(Protocol):
    """What can be watched. All of it is called in one thread alone, the one that made it; messages are those of docs/watching.md.

    `tick` is what is shown now, `done` whether nothing comes after it.
    """

    @property
    def tick(self) -> int:
        """The tick that is shown."""

    @property
    def done(self) -> bool:
        """Whether this is the last tick."""

    def run(self, turn: Callable[[], bool]) -> None:
        """Let time pass: call `turn()` before every tick and after the last, and end when it says False.

        `turn` serves the pages and returns when the next tick is due; while `done` it returns only when it has to end or
        when a request (as `seek`) made `done` false.
        """

    def hello(self) -> Message:
        """Return the first message: {"kind": "hello", …}."""

    def greeting(self) -> list[Message]:
        """Return what else a new page needs, after hello: `marks`, say."""

    def news(self) -> list[Message]:
        """Return what all pages have to hear since the last call, `marks` of a new intervention, say; cheap where there is none."""

    def counts(self) -> dict[str, int]:
        """Return how many there are of each species and object type, for `state`."""

    def frame(self, number: int, colour: str) -> bytes:
        """Return the binary message of this tick: all organisms, coloured by one of `colours` of hello."""

    def scales(self, colour: str) -> dict[str, tuple[float, float]]:
        """Return what the values 1 and 255 of the last frame of this colour mean, for each species that has it."""

    def sample(self) -> None:
        """Note a point of the series, where they are not known beforehand; the player decides how often."""

    def series(self, after: int) -> Message | None:
        """Return the points of later ticks than `after` (−1: all): {"kind": "series", …}; None where there are none."""

    def organism(self, uid: int) -> Message:
        """Return all that is known of one organism now: {"kind": "organism", …}; KeyError where no such one ever was."""

    def handle(self, request: Message) -> list[Message]:
        """Carry out `act`, `params`, `seek`, `fill` and return the answers to the page that asked; refusals are `said`."""
