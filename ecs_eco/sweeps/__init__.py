"""Sweeps: one world under many values, seeds and treatments, a job a run, on any engine.

A job's folder is the unit of work: whoever calls a job again goes on where it was. Processes and clusters
belong to `ecs_eco.experiments`, statistics of single runs to `ecs_eco.analysis`; nothing here prints.
"""

from ecs_eco.sweeps.jobs import run_job
from ecs_eco.sweeps.run import run_sweep

__all__ = ["run_job", "run_sweep"]
