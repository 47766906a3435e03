"""What came of a sweep: its table, figures and page."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ecs_eco.engine.errors import RecordingError
from ecs_eco.sweeps.folder import Sweep
from ecs_eco.sweeps.page import lines_of, write_page
from ecs_eco.sweeps.status import Survey
from ecs_eco.sweeps.table import RUNS, rows_of, write_table


@dataclass(frozen=True)
class Collected:
    """What `collect` wrote."""

    table: Path
    page: Path
    missing: int  # jobs that are not done
    lines: tuple[str, ...]  # the result in words


def collect(sweep: Sweep) -> Collected:
    """Write runs.parquet, sweep.html and figures/ from all jobs that are done.

    Raises RecordingError where none is.
    """
    rows = rows_of(sweep)
    if not rows:
        raise RecordingError(f"{sweep.folder}: no job is done yet: ecs-eco sweep resume {sweep.folder}")
    table = write_table(rows, sweep.folder / RUNS)
    page = write_page(sweep, rows, Survey(sweep).look().failed)
    return Collected(table, page, len(sweep.jobs) - len(rows), lines_of(sweep, rows))
