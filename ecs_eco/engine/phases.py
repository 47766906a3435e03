"""The phases of a tick, and what is put into them."""

from typing import Any, ClassVar

import esper

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


class Scheduled(esper.Processor):
    """What acts once a tick, in its phase, and prepares for a world when it is added to one."""

    phase = "interact"
    divisible: ClassVar[bool] = False  # whether each process may carry it out for its band of a divided world

    def start(self, world: Any) -> None:
        """Prepare for a world; called once, when the system is added."""
