"""Explain a run's evolution: which letters spread, when, and what taking them out again changes.

This package uses recorded runs (`ecs_eco.analysis`, `ecs_eco.record`) and forks them (`ecs_eco.lab`).
"""

from ecs_eco.explain.edits import Edit as Edit
from ecs_eco.explain.taken_out import TakenOut as TakenOut, driver as driver, take_out as take_out
