"""Recordings and checkpoints of runs: series, births, deaths, snapshots and digests.

This package writes and reads these files. Statistics belong in `ecs_eco.analysis`, runs in `ecs_eco.runs`.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy

if TYPE_CHECKING:
    from ecs_eco.record.recorder import Recorder as Recorder

# Recorder, and names used in version 0.1
__getattr__ = lazy(
    __name__,
    {
        ".recorder": "Recorder",
        "ecs_eco.runs.run": "run_to_folder resume fork",
        "ecs_eco.analysis.report": "write_report",
    },
)
__all__ = ["Recorder"]
