"""What the report reads from a run folder besides its series: ages, places and recorded fields; and the check of
its energy ledger."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from ecs_eco.analysis.page import number, table
from ecs_eco.analysis.runs import Series, parts
from ecs_eco.record import seal
from ecs_eco.record.ledger import imbalance
from ecs_eco.record.parquet import each_batch, open_part, read_part, to_codes, to_numpy


def ages_at_death(run: Path | str) -> dict[str, tuple[int, float]]:
    """Deaths and mean age at death [s] of each species, streamed from deaths/*.parquet."""
    totals: dict[str, np.ndarray] = {}
    sealed = seal.has_seals(Path(run))
    for file in parts(run, "deaths"):
        for batch in each_batch(file, ["species", "age"], sealed):
            names, code = to_codes(batch["species"])
            age = to_numpy(batch["age"])
            for i, s in enumerate(names):
                here = age[code == i]
                totals[s] = totals.get(s, np.zeros(2)) + (len(here), here.sum(dtype=np.float64))
    return {s: (int(n), float(total / n) if n else np.nan) for s, (n, total) in totals.items()}


def last_snapshot(run: Path | str, species: tuple[str, ...]) -> tuple[int, dict[str, np.ndarray]] | None:
    """Tick and positions (n, 3) [m] by species of the last snapshot; None where there is none."""
    files = parts(run, "snapshots")
    if not files:
        return None
    rows = read_part(files[-1], ["tick", "species", "x", "y", "z"], seal.has_seals(Path(run)))
    if not len(rows):
        return None
    ticks, place = to_numpy(rows["tick"]), np.stack([to_numpy(rows[c]) for c in "xyz"], 1)
    tick, (names, code) = int(ticks.max()), to_codes(rows["species"])
    of = {s: place[(code == names.index(s)) & (ticks == tick)] for s in species if s in names}
    return tick, {s: at for s, at in of.items() if len(at)}


def fields(run: Path | str) -> list[str]:
    """A table of the fields that the world's key `record` lists: mean and standard deviation in each species at
    birth, at death, in the first and in the last snapshot; nothing where none is listed."""
    births, snapshots = parts(run, "births"), parts(run, "snapshots")
    names = [name for file in births[:1] for name in open_part(file).schema_arrow.names if "." in name]
    if not names:
        return []
    moments = [
        _moments(run, births, names),
        _moments(run, parts(run, "deaths"), names),
        _moments(run, snapshots[:1], names, pc.min),
        _moments(run, snapshots[-1:], names, pc.max),
    ]
    known = dict.fromkeys(
        (s, name) for name in names for found in moments for s, field in found if field == name
    )
    rows = [[name, s, *(found.get((s, name), "–") for found in moments)] for s, name in known]
    head = ["field", "species", "at birth", "at death", "in the first snapshot", "in the last"]
    return ["<h2>Recorded fields</h2>", table(head, rows), "<p class='under'>Mean ± standard deviation.</p>"]


def _moments(
    run: Path | str, files: list[Path], names: list[str], which: Callable[[pa.Array], pa.Scalar] | None = None
) -> dict[tuple[str, str], str]:
    """Mean ± standard deviation by species and field, of all rows or of those of one tick: `which` of them."""
    needed, out = seal.has_seals(Path(run)), {}
    tables = [read_part(file, ["tick", "species", *names], needed) for file in files]
    if not tables:
        return {}
    rows = pa.concat_tables(
        [
            pa.table({n: t[n].cast(pa.string() if n == "species" else pa.float64()) for n in t.column_names})
            for t in tables
        ]
    )
    if which is not None:
        rows = rows.filter(pc.equal(rows["tick"], which(rows["tick"])))
    wanted = [(name, how) for name in names for how in ("mean", "stddev")]
    for row in rows.group_by("species", use_threads=False).aggregate(wanted).to_pylist():
        for name in names:
            if (mean := row[f"{name}_mean"]) is not None:
                out[row["species"], name] = f"{number(mean)} ± {number(row[f'{name}_stddev'])}"
    return out


def ledger_gap(series: Series) -> dict[str, tuple[float, float, int]]:
    """Largest gap of each species' energy ledger: absolute, as a share of the stock, and its tick.

    The stock that a tick starts with must be the one that the tick before ended with.
    """
    c = series.columns
    gap: np.ndarray = np.abs(imbalance(c))
    gap[1:] = np.maximum(gap[1:], np.abs(c["stock_before"][1:] - c["stock_after"][:-1]))
    worst = gap.argmax(0)
    scale = np.maximum(np.abs(c["stock_after"]).max(0), 1.0)
    return {
        s: (float(gap[worst[i], i]), float(gap[worst[i], i] / scale[i]), int(series.ticks[worst[i]]))
        for i, s in enumerate(series.species)
    }
