"""The report of a run folder: one HTML page that a biologist can read, and its figures.

A statistic that the report only shows belongs to `ecs_eco.analysis`.
"""

from ecs_eco.analysis.report.write import rerun, write_report

__all__ = ["rerun", "write_report"]
