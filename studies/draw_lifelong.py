"""Draw docs/img/lifelong.svg from studies/results/lifelong.json: a world in which deer and wolves never stop
learning.

Top: numbers of grass, deer and wolves in one run. Bottom left: numbers of wolves in all runs. Bottom right: how
far both policies moved in each 1,000 ticks.
"""

from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from ecs_eco.analysis.palette import SAFE
from studies.common.figure import draw_result, series
from studies.common.moved import WINDOW
from studies.lifelong import LEARNERS

COLORS = {"grass": "#4d9221", "deer": "#b8860b", "wolf": "#67001f"}
LIVED, DIED = SAFE[6][0], SAFE[2][0]


def draw(record: dict[str, Any], path: Path) -> None:
    """Write a result's figure."""
    plt.rcParams["svg.hashsalt"] = "ecs-eco"
    results = [c["result"] for c in record["cases"] if c["case"]["arm"] == "learning"]
    figure = plt.figure(figsize=(11, 6), layout="constrained")
    halves: Any = figure.subfigures(2, 1)
    numbers(halves[0].subplots(), results[0])
    left, right = halves[1].subplots(1, 2)
    wolves(left, results)
    moves(right, results)
    figure.savefig(path, metadata={"Date": None})


def numbers(ax: Any, result: dict[str, Any]) -> None:
    """Plot one run's population sizes."""
    for name, color in COLORS.items():
        t, n = series(result, name)
        times, label = (0.1, "grass / 10") if name == "grass" else (1, name)
        ax.plot(t, n * times, color=color, lw=1, label=label)
    ax.set(xlim=(0, None), ylim=(0, None), xlabel="1,000 ticks", ylabel="number")
    ax.legend(ncols=3, frameon=False, loc="upper right")
    ax.set_title("the first run", loc="left", fontsize=9)


def wolves(ax: Any, results: list[dict[str, Any]]) -> None:
    """Plot the number of wolves in each run; runs in which a species goes extinct are red."""
    for r in results:
        ax.plot(*series(r, "wolf"), color=LIVED if r["persisted"] else DIED, lw=0.5, alpha=0.6)
    kept = sum(r["persisted"] for r in results)
    ax.set(xlim=(0, None), ylim=(0, None), xlabel="1,000 ticks", ylabel="wolves")
    ax.set_title(f"{kept} of {len(results)} runs persist", loc="left", fontsize=9)


def moves(ax: Any, results: list[dict[str, Any]]) -> None:
    """Plot, for both policies, the median and the middle 80% of the runs' changes in each window."""
    for s in LEARNERS:
        longest = max(len(r["moved"][s]) for r in results)
        table = np.array([r["moved"][s] + [np.nan] * (longest - len(r["moved"][s])) for r in results])
        low, middle, high = np.nanquantile(table, [0.1, 0.5, 0.9], axis=0)
        t = np.arange(longest) + 0.5
        ax.fill_between(t, low, high, color=COLORS[s], alpha=0.2, lw=0)
        ax.plot(t, middle, color=COLORS[s], label=s)
    ax.axhline(0.05, color="black", lw=0.8, ls=":")
    ax.set(yscale="log", xlim=(0, None), xlabel="1,000 ticks", ylabel=f"change in {WINDOW:,} ticks [nats]")
    ax.legend(frameon=False)
    ax.set_title("policies never settle: median and middle 80% of runs", loc="left", fontsize=9)


if __name__ == "__main__":
    draw_result(str(__doc__), "lifelong", "lifelong.svg", draw)
