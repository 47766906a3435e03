"""Recordings and checkpoints of runs: series, births, deaths, snapshots and digests.

This package writes and reads these files. Statistics belong in `ecs_eco.analysis`, runs in `ecs_eco.runs`.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy, listing

if TYPE_CHECKING:
    from ecs_eco.record.recorder import Recorder

_HOME = {
    "Recorder": "record.recorder",
    "run_to_folder": "runs.run",
    "resume": "runs.run",
    "fork": "runs.run",
    "write_report": "analysis.report",
}  # names used in version 0.1
__all__ = ["Recorder"]
__getattr__ = lazy(__name__, {name: f"ecs_eco.{module}" for name, module in _HOME.items()})
__dir__ = listing(globals(), __all__)
