"""Sensitivity indices of a sweep whose points were drawn by Sobol's or Morris's method, computed by SALib."""

from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from typing import Any

import numpy as np

from ecs_eco.analysis.palette import INK
from ecs_eco.analysis.style import PALETTE, Figure, panels, styled
from ecs_eco.analysis.survival import Interval
from ecs_eco.lab.plan import Sample
from ecs_eco.lab.response import Outcome, Row, group, interval, short

NAMES = {"sobol": ("first-order index", "total index"), "morris": ("μ*", "σ")}
Indices = Mapping[str, Sequence[Interval]]  # key: its two indices, as in NAMES


def indices(sample: Sample, y: np.ndarray) -> Indices:
    """Return the indices of each key with 95% intervals (bootstrap over points; σ has none), given the outcome
    at each point. Sobol: the shares of the variance explained by a value alone, and with its interactions
    (Saltelli et al. 2010). Morris: the mean and standard deviation of the changes in the outcome per range
    (Campolongo, Cariboni and Saltelli 2007)."""
    analyze = import_module(f"SALib.analyze.{sample.design}").analyze
    if sample.design == "sobol":
        found = analyze(sample.problem, y, calc_second_order=False, seed=1)
        columns = [found[name] for name in ("S1", "S1_conf", "ST", "ST_conf")]
    else:
        found = analyze(sample.problem, sample.shares(), y, seed=1)
        columns = [
            found["mu_star"],
            found["mu_star_conf"],
            found["sigma"],
            np.full(len(sample.ranges), np.nan),
        ]
    return {
        key: [Interval(x, x - half, x + half) for x, half in (numbers[:2], numbers[2:])]
        for key, numbers in zip(sample.ranges, np.transpose(columns).astype(float).tolist(), strict=True)
    }


def indices_of(
    sample: Sample, rows: Sequence[Row], outcomes: Sequence[Outcome]
) -> Iterator[tuple[str, Outcome, Indices]]:
    """Yield the indices of means over seeds, for each treatment and each complete outcome that varies."""
    for treatment, part in group(rows, lambda row: row["treatment"]).items():
        points = [own for _, own in sorted(group(part, lambda row: row["point"]).items())]
        for outcome in outcomes:
            y = np.array([interval(own, outcome).value for own in points])
            if len(y) == sample.size and np.isfinite(y).all() and np.ptp(y) > 0:
                yield treatment, outcome, indices(sample, y)


def as_rows(design: str, found: Sequence[tuple[str, Outcome, Indices]]) -> list[dict[str, Any]]:
    """Return a table with a row for each treatment, outcome, key and index."""
    return [
        {"treatment": treatment, "outcome": outcome.column, "key": key, "index": name, **x._asdict()}
        for treatment, outcome, own in found
        for key, both in own.items()
        for name, x in zip(NAMES[design], both, strict=True)
    ]


@styled
def figure(design: str, found: Sequence[tuple[str, Outcome, Indices]]) -> Figure:
    """Plot a panel for each treatment and outcome, with both indices of each key."""
    figure, axes = panels(
        len(found), 1, 8, 0.6 + len(found) * (0.9 + 0.35 * len(found[0][2])), sharex=design == "sobol"
    )
    for ax, (treatment, outcome, own) in zip(axes[:, 0], found, strict=True):
        for i, name in enumerate(NAMES[design]):
            at, means = np.arange(len(own)) + 0.4 * i, np.array([both[i] for both in own.values()])
            error = np.nan_to_num(means[:, 2] - means[:, 0])
            ax.barh(at, means[:, 0], 0.38, xerr=error, color=PALETTE[i], ecolor=INK, label=name)
        ax.set_yticks(np.arange(len(own)) + 0.2, [short(key) for key in own])
        ax.invert_yaxis()
        ax.set_title(f"{outcome.label} ({treatment})", fontsize=9.5)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper left", ncols=2)
    return figure
