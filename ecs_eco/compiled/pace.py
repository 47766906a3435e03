"""Choose the faster way to run a tick: work divided among threads, or done by one thread."""

from __future__ import annotations

import math
from collections import deque

SAMPLES = 5  # ticks whose median counts
WARM = 0.3  # [s] after a switch that do not count: threads that slept are slow at first
AGAIN, RARELY = 8, 128  # times the duration of a trial before the next one: at first, and at most
SLOWER = 1.2  # times as slow as when the choice was made: the other way is tried sooner
SOON = 4  # times the duration of a trial before that


class Pace:
    """The recent durations of ticks, in seconds per organism, of each way.

    The slower way is tried again, for some ticks in a row: less and less often, and sooner if the chosen one
    has become slower.
    """

    def __init__(self) -> None:
        self.way = self.better = True  # divided
        self.passed = 0.0  # [s] since the last switch
        self.wait, self.due, self.soon = AGAIN, 0.0, math.inf  # the last two [s], as `passed`
        self.usual = math.inf  # duration per organism when the choice was made [s]
        self.took: dict[bool, deque[float]] = {way: deque(maxlen=SAMPLES) for way in (True, False)}

    def divide(self) -> bool:
        """Return whether to divide the next tick."""
        return self.way

    def note(self, divided: bool, seconds: float, organisms: int = 1) -> None:
        """Record the duration of a tick of this many organisms."""
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
        """Choose the way of a finished trial, or go back."""
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
