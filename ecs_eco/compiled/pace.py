"""Which way of passing a tick takes less time: its work divided between threads, or done by one alone."""

from __future__ import annotations

import math
from collections import deque

SAMPLES = 5  # ticks of which the median counts
WARM = 0.3  # [s] after a change of way that do not count: who slept is slow at first
AGAIN, RARELY = 8, 128  # times what a try took passes before the next one: at first, and in the end
SLOWER = 1.2  # times as long as when the way was chosen: the other one is tried sooner
SOON = 4  # times what a try took passes before that


class Pace:
    """What ticks took lately, in seconds an organism, of each way.

    The way that took longer is tried again, for some ticks in a row: more and more rarely, and sooner where
    the chosen one takes longer than it did.
    """

    def __init__(self) -> None:
        self.way = self.better = True  # divided
        self.passed = 0.0  # [s] since the way changed
        self.wait, self.due, self.soon = AGAIN, 0.0, math.inf  # the last two [s], as `passed`
        self.usual = math.inf  # what an organism took of a tick when the way was chosen [s]
        self.took: dict[bool, deque[float]] = {way: deque(maxlen=SAMPLES) for way in (True, False)}

    def divide(self) -> bool:
        """Return whether to divide the next tick."""
        return self.way

    def note(self, divided: bool, seconds: float, organisms: int = 1) -> None:
        """Keep what a tick of so many organisms took."""
        warm, self.passed = self.passed >= WARM, self.passed + seconds
        took = self.took[divided]
        if not warm:
            return
        took.append(seconds / organisms)
        if len(took) < SAMPLES:
            return
        now = _median(took)
        if divided != self.better:
            self._compare(now)
        elif self.passed >= self.due or (self.passed >= self.soon and now > SLOWER * self.usual):
            self._change()

    def _compare(self, now: float) -> None:
        """Choose the way of a try that is over, or go back from it."""
        was, cost = _median(self.took[self.better]), self.passed
        if now < was:
            self.better, self.wait = self.way, AGAIN
            self.passed = 0.0
        else:
            self._change()
        self.due, self.soon, self.usual = self.wait * cost, SOON * cost, min(now, was)
        self.wait = min(2 * self.wait, RARELY)

    def _change(self) -> None:
        self.way, self.passed = not self.way, 0.0
        self.took[self.way].clear()


def _median(ticks: deque[float]) -> float:
    return sorted(ticks)[len(ticks) // 2]
