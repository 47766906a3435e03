"""The record of each run of a sweep: persistence, numbers, periods, values of reporters, and deaths."""

from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.compare import clean
from ecs_eco.analysis.cycles import cycle_statistics
from ecs_eco.analysis.extinction import lifetime
from ecs_eco.analysis.measures import course, measured, run_mean
from ecs_eco.analysis.runs import DIED, load_series

BOOTSTRAPS = 99  # for the p of a period: cycles of single runs are reported at p ≤ 0.05


def summary_of(run: Path) -> dict[str, Any]:
    """Return the summary of a run folder, as JSON: numbers over the run and at its end, times in ticks."""
    series = load_series(run)
    cycles = cycle_statistics(series, n_boot=BOOTSTRAPS)
    cycling = cycles.cycling() if cycles.enough else ()
    lived, _ = lifetime(series)
    species = {}
    for i, name in enumerate(series.species):
        peak = cycles.peaks.get(name)
        species[name] = {
            "mean": series.n[:, i].mean(),
            "final": series.n[-1, i],
            "extinct": series.extinct[i],
            "period": peak.period if peak is not None and name in cycling else np.nan,
            "period_p": peak.p if peak is not None else np.nan,
            "deaths": {c: n for c in series.causes if (n := series.columns[DIED + c][:, i].sum())},
        }
        if "births" in series.columns:
            species[name]["births"] = series.columns["births"][:, i].sum()
    return dict(
        clean(
            {
                "persisted": series.persisted,
                "lived": lived,
                "species": species,
                "reporters": {
                    what: {
                        of: {"mean": run_mean(series, what, of), "final": course(series, what, of)[-1]}
                        for of in kinds
                    }
                    for what, kinds in measured(series).items()
                },
            }
        )
    )
