"""The posterior of a search as a table, posterior.csv, and in numbers."""

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.engine import files
from ecs_eco.search.sampler import Population, Sampler, statistics_of, value_at, weighted_quantiles

NAME = "posterior.csv"
ENDS = [0.05, 0.5, 0.95]


def write_posterior(sampler: Sampler, out: Path) -> dict[str, Any]:
    """Write posterior.csv, a row for each candidate that was kept, the nearest first; return what
    search.json holds of it.

    The columns are candidate, generation, weight (of sum 1), distance, then each number by its dotted key,
    and each statistic of its run.
    """
    kept = sampler.posterior()
    entries = {e["candidate"]: e for e in sampler.journal.of("candidate")}
    names, measured = [p.name for p in sampler.plan.parameters], list(sampler.fit.observed)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["candidate", "generation", "weight", "distance", *names, *measured])
    for number, weight, distance in rows_of(kept):
        own = statistics_of(entries[number]) or {}
        values = entries[number]["values"]
        table.writerow(
            [
                number,
                sampler.generation(number),
                repr(weight),
                repr(distance),
                *(repr(values[name]) for name in names),
                *(repr(own[name]) for name in measured),
            ]
        )
    files.write(out / NAME, text.getvalue())
    return summary(sampler, kept, entries)


def rows_of(kept: Population) -> list[tuple[int, float, float]]:
    """Candidate, weight and distance of each that was kept."""
    return list(zip(kept.numbers.tolist(), kept.shares.tolist(), kept.distances.tolist(), strict=True))


def summary(sampler: Sampler, kept: Population, entries: dict[int, dict[str, Any]]) -> dict[str, Any]:
    """What search.json holds of a posterior: means and central 90 % intervals of numbers and statistics."""
    there = [e for number, e in entries.items() if number and statistics_of(e) is not None]
    out: dict[str, Any] = {
        "candidates": sum(number > 0 for number in entries),
        "compared": len(there),
        "kept": len(kept.numbers),
        "observed": sampler.fit.observed,
        "generations": 1 + max(map(sampler.generation, entries)),
        "furthest": float(kept.distances.max()) if len(kept.distances) else None,
        "effective": float(1 / (kept.shares**2).sum()) if len(kept.numbers) else 0.0,
        "numbers": {},
        "statistics": {},
    }
    if not len(kept.numbers):
        return out
    for k, p in enumerate(sampler.plan.parameters):
        low, middle, high = weighted_quantiles(kept.at[:, k], kept.shares, ENDS)
        values = [value_at(p, u) for u in kept.at[:, k]]
        out["numbers"][p.name] = {
            "range": [p.low, p.high],
            "mean": float(kept.shares @ np.array(values)),
            "low": value_at(p, low),
            "median": value_at(p, middle),
            "high": value_at(p, high),
        }
    apart = np.array(
        [sampler.fit.differences(statistics_of(entries[n]) or {}) for n in kept.numbers.tolist()]
    )
    for k, (name, observed) in enumerate(sampler.fit.observed.items()):
        low, middle, high = observed + weighted_quantiles(apart[:, k], kept.shares, ENDS)
        out["statistics"][name] = {
            "observed": observed,
            "low": float(low),
            "median": float(middle),
            "high": float(high),
        }
    return out
