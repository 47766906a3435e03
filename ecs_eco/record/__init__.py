"""What a run leaves behind: series, births and deaths, snapshots, manifest, report."""

from importlib import import_module
from typing import Any

_HOME = {"Recorder": "recorder", "run_to_folder": "run", "resume": "run", "fork": "run", "write_report": "report"}
__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"ecs_eco.record has no {name!r}; it has {', '.join(_HOME)}")
    return getattr(import_module(f"ecs_eco.record.{_HOME[name]}"), name)
