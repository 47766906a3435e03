"""Choose the faster mode for running a tick: with work divided among threads, or on a single thread."""

from __future__ import annotations

import math
from collections import deque

SAMPLES = 5  # number of ticks over which the median is taken
WARM = 0.3  # [s] time to ignore after a switch, because threads that have slept are slow at first
AGAIN, RARELY = 8, 128  # first and longest waiting time before the next trial, relative to a trial's duration
SLOWER = 1.2  # the other mode is tried sooner if the chosen mode has slowed down by this factor
SOON = 4  # waiting time before such a trial, relative to a trial's duration


class Pace:
    """The recent durations of ticks in each mode, in seconds per organism.

    The slower mode is tried again for a few ticks in a row, less and less often, but sooner if the chosen
    mode has become slower.
    """

    def __init__(self) -> None:
        self.way = self.better = True  # divided
        self.passed = 0.0  # [s] time since the last switch
        self.wait, self.due, self.soon = AGAIN, 0.0, math.inf  # the last two in [s], like `passed`
        self.usual = math.inf  # duration per organism when the choice was made [s]
        self.took: dict[bool, deque[float]] = {way: deque(maxlen=SAMPLES) for way in (True, False)}

    def divide(self) -> bool:
        """Return whether to divide the next tick."""
        return self.way

    def note(self, divided: bool, seconds: float, organisms: int = 1) -> None:
        """Record the duration of a tick with this many organisms."""
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
        """Choose the mode that was on trial, or go back to the other mode."""
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
