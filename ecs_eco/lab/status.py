"""The progress of a sweep, read from its folder: finished, running, queued and failed jobs, speed and errors."""

import math
import socket
import time
from collections import Counter
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from statistics import fmean, median
from typing import Any

from ecs_eco.engine.errors import ConfigError, RecordingError
from ecs_eco.lab.folder import FAILED, PROGRESS, Sweep
from ecs_eco.lab.jobs import read_done
from ecs_eco.record.claim import owner_of, read_note

RECENT = 5  # finished jobs from which the number of jobs at a time is estimated
ENOUGH = 5.0  # [s] that a job must have run before its rate counts
SILENCE = 600.0  # [s] without a progress record after which a job on another machine counts as lost


@dataclass
class Status:
    """The state of a sweep: job numbers by state, ticks and their rate."""

    done: list[int] = field(default_factory=list)
    running: list[int] = field(default_factory=list)
    waiting: list[int] = field(default_factory=list)
    failed: dict[int, str] = field(default_factory=dict)
    jobs: int = 0
    ticks: int = 0  # completed ticks of all runs
    ticks_in_all: int = 0
    rates: list[float] = field(default_factory=list)  # rates of running jobs, if known [ticks/s]
    each: float = 0.0  # time of a job, from finished jobs, or 0 if none is finished [s]
    left: float = 0.0  # time that the running jobs still need, if a job's time is known [s]
    at_once: float = 1.0  # number of jobs at a time

    @property
    def rate(self) -> float:
        """Return the total ticks per second of running jobs, from the known rates, or 0 if none are known."""
        return len(self.running) * sum(self.rates) / len(self.rates) if self.rates else 0.0

    @property
    def remaining(self) -> float | None:
        """Return the remaining seconds, from the time of finished jobs or the rate of running jobs, if known."""
        if self.each:
            return (len(self.waiting) * self.each + self.left) / self.at_once
        return (self.ticks_in_all - self.ticks) / self.rate if self.rate else None

    def errors(self) -> list[tuple[str, list[int]]]:
        """Return the errors, most frequent first, with the jobs that had them."""
        return [
            (text, [number for number, own in self.failed.items() if own == text])
            for text, _ in Counter(self.failed.values()).most_common()
        ]


class Survey:
    """Surveys a sweep repeatedly, reading finished jobs only once."""

    def __init__(self, sweep: Sweep) -> None:
        self.sweep = sweep
        self._done: dict[int, Mapping[str, Any]] = {}

    def look(self) -> Status:
        sweep, status = self.sweep, Status(jobs=len(self.sweep.jobs))
        status.ticks_in_all = sweep.ticks * status.jobs
        for number in {*range(status.jobs)} - self._done.keys():
            with suppress(RecordingError, ConfigError):
                if (done := read_done(sweep, number)) is not None:
                    self._done[number] = done
        status.done = sorted(self._done)
        status.ticks = sweep.ticks * len(status.done)
        status.each = _each(self._done.values())
        for number in sorted({*range(status.jobs)} - self._done.keys()):
            _look_at(status, number, sweep)
        status.at_once = max(1.0, len(status.running), _at_once(self._done.values()))
        seconds = sum(done["seconds"] for done in self._done.values())
        if not status.rates and seconds:  # all running jobs have just begun
            status.rates.append(sweep.ticks * len(status.done) / seconds)
        return status


def _each(done: Collection[Mapping[str, Any]]) -> float:
    """Return a job's mean time for ticks, plus the median of all other time, as only the first jobs compile."""
    if not done:
        return 0.0
    other = median(max(0.0, one["ended"] - one["began"] - one["seconds"]) for one in done)
    return fmean(one["seconds"] for one in done) + other


def _at_once(done: Collection[Mapping[str, Any]]) -> float:
    """Return how many of the jobs that finished last ran at a time, on average."""
    recent = sorted((one["ended"], one["began"]) for one in done)[-RECENT:]
    span = recent[-1][0] - min(began for _, began in recent) if recent else 0.0
    return sum(ended - began for ended, began in recent) / span if span > 0 else 1.0


def _look_at(status: Status, number: int, sweep: Sweep) -> None:
    place = sweep.job_folder(number)
    note, owner = _numbers(place / PROGRESS), owner_of(place)
    ticks = int(note.get("done", 0))
    status.ticks += ticks
    silent = time.time() - note.get("at", 0.0) > SILENCE
    if owner is not None and (owner.get("host") == socket.gethostname() or not silent):
        status.running.append(number)
        lasted = note.get("at", 0.0) - note.get("began", math.inf)
        rate = (ticks - note.get("from", 0)) / lasted if lasted >= ENOUGH else None
        status.rates += [] if rate is None else [rate]
        left = sweep.ticks - ticks
        status.left += left / rate if rate else status.each * left / sweep.ticks
    elif failure := read_note(place / FAILED):
        status.failed[number] = f"{failure.get('error')}: {failure.get('text')}"
    else:
        status.waiting.append(number)


def _numbers(path: Path) -> dict[str, float]:
    """Return the numbers in a record, ignoring everything else."""
    return {
        key: value
        for key, value in read_note(path).items()
        if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e15
    }
