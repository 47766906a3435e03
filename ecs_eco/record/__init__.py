"""What a run leaves behind: series, births and deaths, snapshots, manifest."""

from importlib import import_module
from typing import Any

_HOME = {
    "Recorder": "ecs_eco.record.recorder",
    "run_to_folder": "ecs_eco.record.run",
    "resume": "ecs_eco.record.run",
    "fork": "ecs_eco.record.run",
    "write_report": "ecs_eco.analysis.report",  # where it was once
}
__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"ecs_eco.record has no {name!r}; it has {', '.join(_HOME)}")
    return getattr(import_module(_HOME[name]), name)
