"""The table of recorded fields in a report: the fields that the world's key `record` lists."""

from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc

from ecs_eco.analysis.page import number, table
from ecs_eco.analysis.runs import tables


def fields(run: Path | str) -> list[str]:
    """Return a table of the fields that the world's key `record` lists: mean and standard deviation in each
    species at birth, at death, and in the first and last snapshot; empty if none is listed."""
    births, snapshots = list(tables(run, "births")), list(tables(run, "snapshots"))
    names = [name for part in births[:1] for name in part.column_names if "." in name]
    if not names:
        return []
    moments = [
        _moments(births, names),
        _moments(list(tables(run, "deaths")), names),
        _moments(snapshots[:1], names, pc.min),
        _moments(snapshots[-1:], names, pc.max),
    ]
    known = dict.fromkeys(
        (s, name) for name in names for found in moments for s, field in found if field == name
    )
    rows = [[name, s, *(found.get((s, name), "–") for found in moments)] for s, name in known]
    head = ["field", "species", "at birth", "at death", "in the first snapshot", "in the last snapshot"]
    return ["<h2>Recorded fields</h2>", table(head, rows), "<p class='under'>Mean ± standard deviation.</p>"]


def _moments(
    parts: list[pa.Table], names: list[str], which: Callable[[pa.Array], pa.Scalar] | None = None
) -> dict[tuple[str, str], str]:
    """Return mean ± standard deviation by species and field, of all rows or one tick, as `which` selects."""
    if not parts:
        return {}
    columns = ["tick", "species", *names]
    rows = pa.concat_tables(
        pa.table({n: t[n].cast(pa.float64()) if n in names else t[n] for n in columns}) for t in parts
    )
    if which is not None:
        rows = rows.filter(pc.equal(rows["tick"], which(rows["tick"])))
    wanted = [(name, how) for name in names for how in ("mean", "stddev")]
    out = {}
    for row in rows.group_by("species", use_threads=False).aggregate(wanted).to_pylist():
        for name in names:
            if (mean := row[f"{name}_mean"]) is not None:
                out[row["species"], name] = f"{number(mean)} ± {number(row[f'{name}_stddev'])}"
    return out
