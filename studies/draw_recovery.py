"""Draw docs/img/recovery.svg from studies/results/recovery.json: the parameters recovered by a sampling
search.

Top: the true parameters of ten worlds, with 90% posterior intervals. Bottom: the posterior from hare and lynx
pelts, and the statistics of its runs next to the measured ones.
"""

from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from ecs_eco.analysis.palette import GREY, SAFE
from ecs_eco.lab.searching.figures import density
from ecs_eco.lab.searching.sampler import value_at
from studies.common.figure import draw_result
from studies.recovery import CHANCE, CONFIG, RATE, plan_of, posterior, split, within

POSTERIOR, MISSED = SAFE[6][0], SAFE[2][0]
TICKS = {CHANCE: [0.1, 0.2, 0.3, 0.5], RATE: [0.01, 0.02, 0.03]}
NAMES = {CHANCE: "probability that a lynx catches", RATE: "rate at which lynx breed [1/s]"}


def draw(record: dict[str, Any], path: Path) -> None:
    """Write a result's figure."""
    plt.rcParams["svg.hashsalt"] = "ecs-eco"
    candidates, truths = split(record["cases"])
    figure, axes = plt.subplots(2, 3, figsize=(11, 6), layout="constrained")
    found = [posterior(CONFIG, candidates, truth["statistics"])[0] for truth in truths]
    for ax, name in zip(axes[0], (CHANCE, RATE), strict=False):
        intervals(ax, found, [truth["values"] for truth in truths], name)
    drawn(axes[0, 2], candidates)
    pelts, kept = posterior(CONFIG, candidates)
    parameters = plan_of(CONFIG).parameters
    at = [i / 200 for i in range(201)]
    for k, ax in enumerate(axes[1][:2]):
        p = parameters[k]
        x = [value_at(p, u) for u in at]
        ax.fill_between(x, density(kept.at[:, k], kept.shares, np.array(at)), color=POSTERIOR, alpha=0.35)
        ax.axhline(1, color=GREY, lw=1)
        ax.set(xscale="log", xlim=(p.low, p.high), ylim=(0, None), yticks=[], xlabel=NAMES[p.name])
        ticked(ax.xaxis, p.name)
        ax.set_title("posterior for the pelts (gray: range)", loc="left", fontsize=9)
    beside(axes[1, 2], pelts)
    figure.savefig(path, metadata={"Date": None})


def intervals(ax: Any, found: list[dict[str, Any]], truths: list[dict[str, float]], name: str) -> None:
    """Plot a parameter's interval in each trial against its true value."""
    for of, truth in zip(found, truths, strict=True):
        n, colour = of["numbers"][name], POSTERIOR if within(of, truth, name) else MISSED
        ax.plot([truth[name]] * 2, [n["low"], n["high"]], color=colour, lw=2)
        ax.plot(truth[name], n["median"], "o", color=colour, ms=4)
    ends = found[0]["numbers"][name]["range"]
    ax.plot(ends, ends, color=GREY, lw=1)
    ax.set(
        xscale="log", yscale="log", xlim=ends, ylim=ends, xlabel=f"true {NAMES[name]}", ylabel="90% interval"
    )
    for axis in (ax.xaxis, ax.yaxis):
        ticked(axis, name)
    ax.set_title("ten worlds with known parameters", loc="left", fontsize=9)


def ticked(axis: Any, name: str) -> None:
    """Label a few values on an axis."""
    axis.set_ticks(TICKS[name], [f"{t:g}" for t in TICKS[name]])
    axis.set_minor_formatter("")


def drawn(ax: Any, candidates: list[dict[str, Any]]) -> None:
    """Draw all candidates, marked by whether both species survived."""
    for lived, colour, label in ((True, POSTERIOR, "both persist"), (False, MISSED, "at least one dies out")):
        of = [c["values"] for c in candidates if (c["statistics"] is not None) == lived]
        ax.plot(
            [v[CHANCE] for v in of],
            [v[RATE] for v in of],
            "o" if lived else "x",
            color=colour,
            ms=3,
            label=f"{label} ({len(of)})",
        )
    ax.set(xscale="log", yscale="log", xlabel=NAMES[CHANCE], ylabel=NAMES[RATE])
    ticked(ax.xaxis, CHANCE)
    ticked(ax.yaxis, RATE)
    ax.legend(fontsize=8)
    ax.set_title("candidates", loc="left", fontsize=9)


def beside(ax: Any, pelts: dict[str, Any]) -> None:
    """Plot each statistic's measured value and its values in the posterior's runs."""
    for row, of in enumerate(pelts["statistics"].values()):
        inside = of["low"] <= of["observed"] <= of["high"]
        ax.plot([of["low"], of["high"]], [row] * 2, color=GREY, lw=5, solid_capstyle="butt")
        ax.plot(of["observed"], row, "o" if inside else "x", color="black", ms=5)
    ax.set_yticks(range(len(pelts["statistics"])), list(pelts["statistics"]), fontsize=8)
    ax.invert_yaxis()
    ax.set_xlabel("log10, or share of the period")
    ax.set_title("pelts, and runs from their posterior (90%)", loc="left", fontsize=9)


if __name__ == "__main__":
    draw_result(str(__doc__), "recovery", "recovery.svg", draw)
