"""Records of a run: series, births and deaths, snapshots, in sealed files.

Writing and reading them belongs here; statistics belong to `ecs_eco.analysis`, running to `ecs_eco.runs`.
"""

from ecs_eco._lazy import lazy

_HOME = {"Recorder": "record.recorder", "run_to_folder": "runs.run", "resume": "runs.run", "fork": "runs.run",
         "write_report": "analysis.report"}  # the last four stood here in version 0.1  # fmt: skip
__all__ = list(_HOME)
__getattr__ = lazy(__name__, {name: f"ecs_eco.{module}" for name, module in _HOME.items()})
