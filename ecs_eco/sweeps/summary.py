"""What is kept of each run of a sweep: persistence, numbers, periods, what reporters measured, and deaths."""

from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.compare import clean
from ecs_eco.analysis.cycles import cycle_statistics
from ecs_eco.analysis.extinction import lifetime
from ecs_eco.analysis.measures import course, measured, run_mean
from ecs_eco.analysis.runs import DIED, Series, load_series

BOOTSTRAPS = 99  # for the p of a period: cycles of single runs are told at p ≤ .05


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
            "deaths": _deaths(series, i),
        }
        if "births" in series.columns:
            species[name]["births"] = series.columns["births"][:, i].sum()
    return dict(
        clean(
            {
                "persisted": series.persisted,
                "lived": lived,
                "species": species,
                "reporters": _reporters(series),
            }
        )
    )


def _deaths(series: Series, i: int) -> dict[str, float]:
    """Return the deaths of a species by cause."""
    counts = {cause: series.columns[DIED + cause][:, i].sum() for cause in series.causes}
    return {cause: n for cause, n in counts.items() if n}


def _reporters(series: Series) -> dict[str, dict[str, dict[str, float]]]:
    """Return reporter → species, or the world → mean over the run, and the last number."""
    return {
        name: {
            of: {"mean": run_mean(series, name, of), "final": course(series, name, of)[-1]} for of in kinds
        }
        for name, kinds in measured(series).items()
    }
