"""The progress of a sweep, read from its folder: finished, running, queued and failed jobs, speed, and
errors."""

import json
import math
import socket
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ecs_eco.engine.errors import ConfigError, RecordingError
from ecs_eco.lab.folder import FAILED, PROGRESS, Sweep
from ecs_eco.lab.jobs import read_done
from ecs_eco.record.claim import owner_of

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
    seconds: float = 0.0  # total time of finished runs [s]

    @property
    def rate(self) -> float:
        """Return the total ticks per second of running jobs, from the known rates, or 0 if none are known."""
        return len(self.running) * sum(self.rates) / len(self.rates) if self.rates else 0.0

    @property
    def remaining(self) -> float | None:
        """Return the remaining seconds at the current rate, or None if the rate is unknown."""
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
        self._done: dict[int, float] = {}

    def look(self) -> Status:
        """Return the current state of the sweep."""
        sweep, status = self.sweep, Status(jobs=len(self.sweep.jobs))
        status.ticks_in_all = sweep.ticks * status.jobs
        for job in sweep.jobs:
            if job.number in self._done or self._is_done(job.number):
                status.done.append(job.number)
                status.ticks += sweep.ticks
            else:
                _look_at(status, job.number, sweep.job_folder(job.number))
        status.seconds = sum(self._done.values())
        if not status.rates and status.seconds:  # all running jobs have just begun
            status.rates.append(sweep.ticks * len(status.done) / status.seconds)
        return status

    def _is_done(self, number: int) -> bool:
        try:
            done = read_done(self.sweep, number)
        except (RecordingError, ConfigError):
            return False
        if done is not None:
            self._done[number] = float(done["seconds"])
        return done is not None


def _look_at(status: Status, number: int, place: Path) -> None:
    """Add an unfinished job to the status."""
    note, owner = _numbers(place / PROGRESS), owner_of(place)
    ticks = int(note.get("done", 0))
    status.ticks += ticks
    silent = time.time() - note.get("at", 0.0) > SILENCE
    if owner is not None and (owner.get("host") == socket.gethostname() or not silent):
        status.running.append(number)
        lasted = note.get("at", 0.0) - note.get("began", math.inf)
        if lasted >= ENOUGH:
            status.rates.append((ticks - note.get("from", 0)) / lasted)
    elif failure := _read(place / FAILED):
        status.failed[number] = f"{failure.get('error')}: {failure.get('text')}"
    else:
        status.waiting.append(number)


def _numbers(path: Path) -> dict[str, float]:
    """Return the numbers in a record, ignoring everything else."""
    return {
        key: value
        for key, value in _read(path).items()
        if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e15
    }


def _read(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}
