"""What the report reads from a run folder besides its series, and the check of its energy ledger."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ecs_eco.analysis.runs import Series, parts
from ecs_eco.record import seal
from ecs_eco.record.ledger import imbalance
from ecs_eco.record.parquet import each_batch, read_part, to_codes, to_numpy


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
