"""The phases of a tick, the processors in them, and their order."""

from operator import attrgetter
from typing import Any, ClassVar

from esper import Processor

PHASES = (
    "environment",
    "sense",
    "feel",
    "learn",
    "decide",
    "move",
    "interact",
    "metabolise",
    "die",
    "reproduce",
    "record",
)
"""The phases of a tick, in order.

Deaths take effect at the end of `die`, births at the end of `reproduce`.
"""
LAST = 999_999  # position in a phase after all systems


class Scheduled(Processor):
    """A processor that acts once per tick, in its phase; `start` prepares it for its world."""

    phase = "interact"
    divisible: ClassVar[bool] = False  # whether each process of a divided world can run it for its band

    def start(self, world: Any) -> None:
        """Prepare for a world; called once, when the system is added."""


class Schedule(list[Processor]):
    """A tick's processors in the order in which they act."""

    def put(self, processor: Processor, priority: int) -> None:
        """Insert a processor after all others with the same priority."""
        processor.priority = priority
        self.append(processor)
        self.sort(key=attrgetter("priority"), reverse=True)


def priority_of(phase: str, place: int) -> int:
    """Return the esper priority of a position in a phase: priorities count down from 0, with one million per
    phase."""
    return -(PHASES.index(phase) * (LAST + 1) + place)
