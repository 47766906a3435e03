"""Draw docs/img/real_series.svg from studies/results/real_series.json: measured cycles next to the cycles of
shipped worlds.

Top: the series, each scaled to its own period. Bottom: their measures, with central 95% ranges of the worlds'
windows and points for measured pairs.
"""

import csv
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from ecs_eco.analysis.signature import period_of
from studies.common.figure import draw_result
from studies.common.goats import numbers
from studies.real_series import BLOCK, DATA, MEASURES, SERIES, compare, measured

PREY, PREDATOR = "#0072b2", "#d55e00"  # distinguishable by color-blind readers (Okabe and Ito 2008)
NAMES = {
    "lynx-hare": "hare, lynx (pelts)",
    "isle-royale": "moose, wolf",
    "fir-moose": "fir rings, moose",
    "huffaker-60": "mites, 60 weeks",
    "huffaker-24": "mites, 24 weeks",
    "gause": "Paramecium, Didinium",
}
WORLD = ("predator-prey", "deer→wolf")
SHOWN = 3.0  # number of periods of a world's run to draw
SHIFT = 0.08


def draw(record: dict[str, Any], path: Path) -> None:
    """Write a result's figure."""
    plt.rcParams["svg.hashsalt"] = "ecs-eco"
    figure, axes = plt.subplots(3, 4, figsize=(11, 7.5), layout="constrained")
    first = next(e for e in record["cases"] if e["case"]["arm"] == WORLD[0])["result"]["numbers"]
    prey, predator = (numbers(first[name]) for name in WORLD[1].split("→"))
    period = period_of(prey, predator)
    part = slice(len(prey) // 10, len(prey) // 10 + int(SHOWN * period))
    panels = axes.ravel()
    pair(panels[0], prey[part], predator[part], "deer, wolf (world)", period)
    for ax, name in zip(panels[1:7], SERIES, strict=True):
        pair(ax, *measured(name), NAMES[name], None)
    lynx(panels[7])
    compared = compare(record["cases"])
    for ax, measure in zip(panels[8:], MEASURES, strict=True):
        against(ax, compared, measure)
    panels[0].set_xlabel(f"period of {period * BLOCK:,.0f} ticks")
    figure.savefig(path, metadata={"Date": None})


def pair(ax: Any, prey: np.ndarray, predator: np.ndarray, title: str, period: float | None) -> None:
    """Plot two series, as shares of their maxima, over time in periods."""
    period = period or period_of(prey, predator)
    t = np.arange(len(prey)) / period
    for series, colour in ((prey, PREY), (predator, PREDATOR)):
        ax.plot(t, series / series.max(), color=colour, lw=1.2, marker="o" * (len(t) < 100), ms=2)
    ax.set_title(title, loc="left", fontsize=9)
    ax.set_xlabel(f"periods of {period:.1f} samples", fontsize=8)
    ax.tick_params(labelsize=7)


def lynx(ax: Any) -> None:
    """Plot the long lynx series, for which no prey series exists."""
    with open(DATA / "mackenzie_lynx.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    caught = np.array([float(row["lynx"]) for row in rows])
    ax.plot([int(row["year"]) for row in rows], caught / caught.max(), color=PREDATOR, lw=1)
    ax.set_title("lynx, 1821 to 1934", loc="left", fontsize=9)
    ax.set_xlabel(f"year; period of {period_of(caught):.1f} years", fontsize=8)
    ax.tick_params(labelsize=7)


def against(ax: Any, compared: dict[tuple[str, str, str], dict[str, Any]], measure: str) -> None:
    """Plot a measure: the central 95% of a world's windows as bars and the measured pairs as points."""
    for row, name in enumerate(SERIES):
        of = compared.get((*WORLD, name))
        if of is None:
            continue
        low, high, inside = of[measure]
        value = of["real"][measure]
        if measure == "lag":  # shift it to within half a period of the bar's center
            middle = (low + high) / 2
            value = middle + (value - middle + 0.5) % 1 - 0.5
        ax.plot([low, high], [row + SHIFT] * 2, color="#999999", lw=5, solid_capstyle="butt")
        ax.plot(value, row - SHIFT, "o" if inside else "x", color="black", ms=5)
    ax.set_yticks(range(len(SERIES)), [NAMES[name] for name in SERIES] if measure == "lag" else [])
    ax.invert_yaxis()
    ax.set_title(
        {
            "lag": "lag [periods]",
            "prey swing": "swing of the prey [log10]",
            "predator swing": "swing of the predator [log10]",
        }.get(measure, measure),
        loc="left",
        fontsize=9,
    )
    ax.tick_params(labelsize=7)


if __name__ == "__main__":
    draw_result(str(__doc__), "real_series", "real_series.svg", draw)
