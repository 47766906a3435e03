"""When a search ends: by its time, its number of candidates, or their CPU seconds."""

import time
from collections.abc import Callable

import numpy as np

from ecs_eco.engine.errors import ConfigError, Problem
from ecs_eco.search.journal import Journal
from ecs_eco.search.plan import Plan

# share of the time kept for finals and confirmation, before any run at full length was timed
FIRST_RESERVE = 0.25
MOST_RESERVE = 0.6  # share of the time kept at most, however long such runs take


class Budget:
    """The budget of a search, earlier calls included, and what it has used so far."""

    def __init__(self, minutes: float | None, trials: int | None, cpu: float | None, workers: int) -> None:
        if minutes is None and trials is None and cpu is None:
            allowed = "a budget in minutes, or a number of trials"
            raise ConfigError([Problem((), "no end", allowed=allowed, source="--budget, --trials")])
        self.seconds = None if minutes is None else minutes * 60
        self.trials, self.cpu, self.workers = trials, cpu, workers
        self._begun = time.monotonic()

    def begin(self, plan: Plan, journal: Journal, finalists: Callable[[], int]) -> None:
        """Start the clock, with the time of earlier calls; `finalists` returns the number of finalists."""
        self._plan, self._journal, self._finalists = plan, journal, finalists
        self._before = max((float(e["at"]) for e in journal.entries), default=0.0)
        self._begun = time.monotonic()

    @property
    def elapsed(self) -> float:
        """Seconds that the search has taken."""
        return round(self._before + time.monotonic() - self._begun, 3)

    @property
    def worked(self) -> float:
        """CPU seconds of candidates."""
        return float(sum(e["cpu"] for e in self._journal.of("candidate")))

    @property
    def share(self) -> float:
        """How much of the search is over, in [0, 1]."""
        shares = [len(self._journal.of("candidate")) / self.trials] if self.trials else []
        shares += [self.elapsed / self.seconds] if self.seconds else []
        shares += [self.worked / self.cpu] if self.cpu else []
        return min(1.0, max(shares, default=0.0))

    def allows_another(self, running: int) -> bool:
        """Return whether one more candidate may begin beside those that are running; the first always may."""
        n = len(self._journal.of("candidate")) + running
        if self.trials is not None and n >= self.trials:
            return False
        if self.cpu is not None and self.worked >= self.cpu:
            return False
        return n == 0 or self.seconds is None or self.elapsed < self.seconds - self._reserve() - self._usual()

    def is_over(self) -> bool:
        """Return whether no time is left for candidates; never before there is one."""
        if self.seconds is None or not self._journal.of("candidate"):
            return False
        return self.elapsed > self.seconds - self._reserve()

    def _usual(self) -> float:
        """Seconds that a candidate usually takes."""
        seconds = [e["seconds"] for e in self._journal.of("candidate")]
        return float(np.median(seconds)) if seconds else 0.0

    def _reserve(self) -> float:
        """Seconds to keep for finals and confirmation, from the times of runs at full length."""
        seconds, plan = self.seconds or 0.0, self._plan
        run = self._seconds_a_run()
        if run is None:
            return FIRST_RESERVE * seconds
        confirmation = len(plan.confirmation) * plan.confirmation_ticks / plan.ticks
        runs = self._finalists() * len(plan.finals) + confirmation
        return min(1.15 * runs * run / self.workers, MOST_RESERVE * seconds)

    def _seconds_a_run(self) -> float | None:
        """Seconds of a run at full length with its share of the training; None before there was one."""
        last = len(self._plan.stages) - 1
        whole = [e for e in self._journal.of("candidate") if len(e["stages"]) > last]
        seconds = [e["seconds"] / len(e["stages"][last]["runs"]) for e in whole]
        return float(np.median(seconds)) if seconds else None
