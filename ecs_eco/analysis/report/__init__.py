"""The report of a run folder: one HTML page for biologists, and its figures.

Statistics belong in `ecs_eco.analysis`; this package only presents them.
"""

from ecs_eco.analysis.report.write import rerun, write_report

__all__ = ["rerun", "write_report"]
