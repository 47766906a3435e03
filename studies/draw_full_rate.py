"""Draw docs/img/full_rate.svg from studies/results/full_rate.json: learning at the full rate during life.

Top: numbers of wolves over time, with one line per run and one panel per set of learning species. Bottom: a
wolf's catch in the arena for combinations of initial and final policies, and how far deer and wolf policies
moved.
"""

from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import FixedLocator, NullLocator

from ecs_eco.analysis.palette import GREY, SAFE
from studies.common.figure import draw_result
from studies.common.seed_grid import BLOCK
from studies.full_rate import CONFIG, LEARNERS, PAIRS, caught, pace

LIVED, DIED = SAFE[6][0], SAFE[2][0]
ARMS = {
    "neither": "no learning",
    "deer": "deer learn",
    "wolves": "wolves learn",
    "both": "both learn",
    "individual": "both, individual brains",
    "regime": "both, other parameters",
}


def draw(record: dict[str, Any], path: Path) -> None:
    """Write a result's figure."""
    plt.rcParams["svg.hashsalt"] = "ecs-eco"
    of = {arm: [c["result"] for c in record["cases"] if c["case"]["arm"] == arm] for arm in ARMS}
    drawn = [c["result"] for c in record["cases"] if c["case"]["arm"] == "search"]
    figure = plt.figure(figsize=(12, 6.6), layout="constrained")
    halves: Any = figure.subfigures(2, 1)
    axes = halves[0].subplots(1, len(ARMS), sharey=True)
    for ax, (arm, results) in zip(axes, of.items(), strict=True):
        over_time(ax, results, ARMS[arm])
    axes[0].set(ylim=(0, None), ylabel="wolves")
    left, right = halves[1].subplots(1, 2)
    arena(left, [r for r in of["both"] if "arena" in r])
    moves(right, of, drawn)
    figure.savefig(path, metadata={"Date": None})


def over_time(ax: Any, results: list[dict[str, Any]], title: str) -> None:
    """Plot the number of wolves in each run; runs in which they go extinct are red."""
    for r in results:
        n = [float(v) for v in r["series"]["wolf"].split()]
        t = BLOCK * (np.arange(len(n)) + 0.5)
        ax.plot(t / 1000, n, color=LIVED if r["persisted"] else DIED, lw=0.8, alpha=0.7)
    kept = sum(r["persisted"] for r in results)
    ax.set(xlim=(0, CONFIG["ticks"] / 1000), xlabel="1,000 ticks")
    ax.set_title(f"{title}:\n{kept} of {len(results)} persist", loc="left", fontsize=9)


def arena(ax: Any, results: list[dict[str, Any]]) -> None:
    """Plot a wolf's catch for each pair of policies: a line for each training seed, and the mean."""
    names = [*PAIRS, "answer"]
    values = np.array([[caught(name)(r) for name in names] for r in results])
    ax.plot(values.T, "o-", color=GREY, ms=3, lw=0.8)
    ax.plot(values.mean(0), "_", color="black", ms=26, mew=2)
    ax.set_xticks(
        range(len(names)),
        [*(p.replace(", ", ",\n") for p in PAIRS), "last deer,\nlearning wolves"],
        fontsize=8,
    )
    ax.set(ylim=(0, None), ylabel="deer caught per wolf in 100 ticks")
    ax.set_title("arena: one line per training seed, bars are means", loc="left", fontsize=9)


def moves(ax: Any, of: dict[str, list[dict[str, Any]]], drawn: list[dict[str, Any]]) -> None:
    """Plot how far both policies moved in each run in which both species learn."""
    ax.set(xscale="log", yscale="log")
    for marker, label, results in (
        ("s", "shipped parameters", of["both"]),
        ("^", "individual brains", of["individual"]),
        ("o", "other wolf parameters", of["regime"]),
        ("x", "drawn at random", drawn),
    ):
        for persisted, colour in ((True, LIVED), (False, DIED)):
            at = [[pace(r, s) for s in LEARNERS] for r in results if r["persisted"] == persisted]
            if at:
                ax.plot(
                    *np.array(at).T,
                    marker,
                    color=colour,
                    ms=5,
                    alpha=0.8,
                    mfc="none",
                    label=f"{label}, wolves {'persist' if persisted else 'die out'}",
                )
    for line in (ax.axhline, ax.axvline):
        line(CONFIG["nats"], color=GREY, lw=1)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(FixedLocator([0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1]))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())
    ax.set(
        xlabel="change of the deer policy in 1,000 ticks [nats]", ylabel="change of the wolf policy [nats]"
    )
    ax.legend(fontsize=7, loc="center left", bbox_to_anchor=(1, 0.5))
    ax.set_title("change of both policies (gray: 0.05 nats)", loc="left", fontsize=9)


if __name__ == "__main__":
    draw_result(str(__doc__), "full_rate", "full_rate.svg", draw)
