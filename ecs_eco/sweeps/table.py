"""What came of a sweep: its table, a row for each run that is done, its figures and page."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ecs_eco.analysis.measures import WORLD
from ecs_eco.engine.errors import RecordingError
from ecs_eco.sweeps.folder import Sweep
from ecs_eco.sweeps.jobs import read_done
from ecs_eco.sweeps.page import lines_of, write_page
from ecs_eco.sweeps.status import Survey

RUNS = "runs.parquet"
UNTREATED = "world"  # the world as it is, among treatments


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


def rows_of(sweep: Sweep) -> list[dict[str, Any]]:
    """Return a row for each job that is done, in their order; all rows have the same keys."""
    rows = [
        row_of(job.point, done) for job in sweep.jobs if (done := read_done(sweep, job.number)) is not None
    ]
    columns = sorted({name for row in rows for name in row}, key=_place(rows))
    return [{name: row.get(name, 0.0 if ".died." in name else None) for name in columns} for row in rows]


def row_of(point: int, done: dict[str, Any]) -> dict[str, Any]:
    """Return the row of a job that is done: what identifies it, its values, and what came of it.

    Times are in ticks; "deer.mean" and "deer.final" are numbers over the run and at its end, "deer.period" is
    there where it cycles, "deer.died.starved" counts deaths.
    """
    summary = done["summary"]
    row = {
        "job": done["number"],
        "point": point,
        **done["values"],
        "treatment": done["treatment"] or UNTREATED,
        "training_seed": done["training_seed"],
        "world_seed": done["world_seed"],
        "ticks": done["ticks"],
        "persisted": summary["persisted"],
        "lived": summary["lived"],
    }
    for name, numbers in summary["species"].items():
        row |= {f"{name}.{key}": value for key, value in numbers.items() if key != "deaths"}
        row |= {f"{name}.died.{cause}": n for cause, n in numbers["deaths"].items()}
    for name, kinds in summary["reporters"].items():
        for of, numbers in kinds.items():
            of = "" if of == WORLD else f".{of}"
            row |= {f"{name}{of}.{key}": value for key, value in numbers.items()}
    return row | {
        "seconds": done["seconds"],
        "host": done["host"],
        "git_commit": done["git_commit"],
        "config_hash": done["config_hash"],
        "digest": done["digest"],
    }


def _place(rows: list[dict[str, Any]]) -> Any:
    """Return a key that sorts columns as the rows have them, those that only some have beside the others."""
    places: dict[str, tuple[int, str]] = {}
    for row in rows:
        at = 0
        for name in row:
            at = places[name][0] if name in places else at
            places.setdefault(name, (at, name))
    return lambda name: places[name]


def write_table(rows: list[dict[str, Any]], path: Path) -> Path:
    """Write rows as a Parquet file, whole or not at all. Values of one key of several types become texts."""
    import pyarrow as pa

    from ecs_eco.record.parquet import write_part

    columns = {}
    for name in rows[0]:
        values = [row[name] for row in rows]
        if len({type(v) for v in values if v is not None} - {int, float}) > 1 or any(
            isinstance(v, list | dict) for v in values
        ):
            values = [str(v) for v in values]
        elif any(isinstance(v, float) for v in values):
            values = [None if v is None else float(v) for v in values]
        columns[name] = values
    write_part(pa.table(columns), path)
    return path
