"""The posterior of a search, as a table (posterior.csv), summary statistics and figures."""

import csv
import io
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.page import drawn, number, table
from ecs_eco.analysis.palette import GREY, INK, SAFE
from ecs_eco.analysis.style import Figure, several, styled
from ecs_eco.engine import files
from ecs_eco.engine.errors import in_words
from ecs_eco.lab.searching.figures import scaled
from ecs_eco.lab.searching.plan import Parameter
from ecs_eco.lab.searching.sampler import Population, Sampler, statistics_of, value_at, weighted_quantiles

NAME = "posterior.csv"
ENDS = [0.05, 0.5, 0.95]


def write_posterior(sampler: Sampler, out: Path) -> dict[str, Any]:
    """Write posterior.csv, with a row for each accepted candidate, nearest first: candidate, generation,
    weight (summing to 1), distance, parameter values by dotted key, statistics; return the posterior's entry in
    search.json."""
    kept = sampler.posterior()
    entries = {e["candidate"]: e for e in sampler.journal.of("candidate")}
    names, measured = [p.name for p in sampler.plan.parameters], list(sampler.fit.observed)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["candidate", "generation", "weight", "distance", *names, *measured])
    columns = (kept.numbers.tolist(), kept.shares.tolist(), kept.distances.tolist())
    for candidate, weight, distance in zip(*columns, strict=True):
        own = statistics_of(entries[candidate]) or {}
        values = entries[candidate]["values"]
        table.writerow(
            [
                candidate,
                sampler.generation(candidate),
                repr(weight),
                repr(distance),
                *(repr(values[name]) for name in names),
                *(repr(own[name]) for name in measured),
            ]
        )
    files.write(out / NAME, text.getvalue())
    return summary(sampler, kept, entries)


def summary(sampler: Sampler, kept: Population, entries: dict[int, dict[str, Any]]) -> dict[str, Any]:
    """Return the posterior's entry in search.json: means and central 90% intervals."""
    out: dict[str, Any] = {
        "candidates": sum(number > 0 for number in entries),
        "compared": sum(number > 0 and statistics_of(e) is not None for number, e in entries.items()),
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
        out["numbers"][p.name] = {
            "range": [p.low, p.high],
            "mean": float(kept.shares @ np.array([value_at(p, u) for u in kept.at[:, k]])),
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


POSTERIOR, START = SAFE[6][0], INK
MOST = 6  # maximum number of parameters in the figure of pairs


def posterior_opening(result: dict[str, Any]) -> list[str]:
    """Return sentences on the parameters, narrowest first, and the measurements that are not predicted."""
    known = {
        name: (of["high"] - of["low"]) / (of["range"][1] - of["range"][0])
        for name, of in result["numbers"].items()
    }
    told = [
        f"{name} = {number(of['median'])} ({number(of['low'])} to {number(of['high'])})"
        for name in sorted(known, key=known.__getitem__)[:3]
        for of in [result["numbers"][name]]
    ]
    lines = [f"Median and central 90% of the posterior: {', '.join(told)}."] if told else []
    outside = [name for name, of in result["statistics"].items() if _place(of)]
    if outside:
        lines.append(
            f"The posterior does not predict {in_words(outside)}: the measured value is outside the central 90% "
            "of the runs. The world may lack a process that causes it."
        )
    elif told:
        lines.append(f"It predicts {in_words(result['statistics'])}.")
    return lines


def posterior_blocks(sampler: Sampler, result: dict[str, Any], folder: Path) -> list[str]:
    """Return the section on the posterior; its figures are also written to `folder`."""
    kept = sampler.posterior()
    if not result["numbers"]:
        return ["<h2>Posterior</h2>", "<p>No candidate lived long enough to be compared.</p>"]
    told = (
        f"<p>Of {result['candidates']} candidates, {result['compared']} lived long enough to be compared; "
        f"the {result['kept']} nearest form the posterior (posterior.csv), equivalent to "
        f"{number(result['effective'])} candidates of equal weight.</p>"
    )
    numbers = [
        [
            name,
            f"{number(of['range'][0])} … {number(of['range'][1])}",
            number(of["median"]),
            f"{number(of['low'])} … {number(of['high'])}",
        ]
        for name, of in result["numbers"].items()
    ]
    statistics = [
        [
            name,
            number(of["observed"]),
            number(of["median"]),
            f"{number(of['low'])} … {number(of['high'])}",
            _place(of),
        ]
        for name, of in result["statistics"].items()
    ]
    parameters = sampler.plan.parameters
    shown = [
        drawn(
            marginals(parameters, kept, sampler.plan.start),
            folder / "posterior.svg",
            "Posterior density of each parameter on the scale of its range, with "
            "the median and central 90%; the gray line is the prior density.",
        )
    ]
    if len(parameters) > 1:
        caption = "Pairs of parameters; the area of a dot shows the weight of a candidate."
        shown.append(drawn(pairs(parameters, kept), folder / "posterior-pairs.svg", caption))
    return [
        "<h2>Posterior</h2>",
        told,
        table(["parameter", "range", "median", "central 90%"], numbers),
        *shown,
        table(["statistic", "measured", "median of the runs", "central 90%", "measured value"], statistics),
    ]


def _place(of: dict[str, float]) -> str:
    """Return "above" or "below" if the measured value is outside the central 90%, else ""."""
    return "below" if of["observed"] < of["low"] else "above" if of["observed"] > of["high"] else ""


@styled
def marginals(parameters: tuple[Parameter, ...], kept: Population, start: dict[str, float]) -> Figure:
    """Plot the posterior density of each parameter over its range."""
    figure, axes = several(len(parameters), 4, (2.9, 2.3), (0.4, 0.3))
    at = np.linspace(0, 1, 201)
    for k, (ax, p) in enumerate(zip(axes.flat, parameters, strict=False)):
        x = [value_at(p, u) for u in at]
        ax.fill_between(x, density(kept.at[:, k], kept.shares, at), color=POSTERIOR, alpha=0.35, lw=0)
        ax.axhline(1, color=GREY, lw=1)
        low, middle, high = weighted_quantiles(kept.at[:, k], kept.shares, ENDS)
        ax.plot([value_at(p, low), value_at(p, high)], [0, 0], color=POSTERIOR, lw=4, clip_on=False)
        ax.axvline(value_at(p, middle), color=POSTERIOR, lw=1.4, label="median")
        ax.axvline(start[p.name], color=START, lw=1.2, ls=":", label="as written")
        ax.set(ylim=(0, None), yticks=[])
        scaled(ax.xaxis, p, fontsize=9)
        ax.set_xlim(p.low, p.high)
    axes[0, 0].legend(loc="best", fontsize=9)
    return figure


@styled
def pairs(parameters: tuple[Parameter, ...], kept: Population) -> Figure:
    """Plot the posterior over pairs of the first parameters."""
    chosen = list(combinations(range(min(MOST, len(parameters))), 2))
    figure, axes = several(len(chosen), 3, (3.3, 2.9), (0.3, 0.2))
    for ax, (i, j) in zip(axes.flat, chosen, strict=False):
        x, y = ([value_at(parameters[k], u) for u in kept.at[:, k]] for k in (i, j))
        ax.scatter(x, y, s=20 + 400 * kept.shares, color=POSTERIOR, alpha=0.5, lw=0, clip_on=False)
        scaled(ax.xaxis, parameters[i], fontsize=9)
        scaled(ax.yaxis, parameters[j], fontsize=9)
        ax.set(xlim=(parameters[i].low, parameters[i].high), ylim=(parameters[j].low, parameters[j].high))
    return figure


def density(places: np.ndarray, shares: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return the normal-kernel density of weighted positions (Silverman's width), mirrored at 0 and 1."""
    mean = shares @ places
    wide = max(0.02, np.sqrt(shares @ (places - mean) ** 2) * (1.06 * (shares**2).sum() ** 0.2))
    mirrored = np.concatenate([places, -places, 2 - places])
    kernel = np.exp(-0.5 * ((at[:, None] - mirrored) / wide) ** 2)
    return np.asarray(kernel @ np.tile(shares, 3) / (wide * np.sqrt(2 * np.pi)))
