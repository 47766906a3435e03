"""Draw docs/img/deer_that_flee.svg from studies/results/deer_that_flee.json: where running from a wolf pays,
the share of animals that run by distance, and the number of deer in each arm.

    python -m studies.draw_deer_that_flee
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from studies.common.figure import draw_result
from studies.common.pursuit import EDGES
from studies.deer_that_flee import REGISTERED, gain

COLOURS = dict(zip(REGISTERED.arms, ("#555555", "#009e73", "#d55e00"), strict=True))  # Okabe and Ito 2008
SAYS = {"shipped": "as shipped", "fleeing": "running is cheap", "walkers": "the same world, shipped deer"}
BLOCK = 40  # [ticks] averaged into each stored mean


def draw(result: dict[str, Any], path: Path) -> Path:
    """Write the figure."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 8.2), layout="constrained")
    rows = figure.subfigures(3, 1, height_ratios=(1, 1, 1.1))
    places(rows[0], result)
    for axis, who, other in zip(
        rows[1].subplots(1, 2, sharey=True), ("deer", "wolf"), ("wolf", "deer"), strict=True
    ):
        curves(axis, result, who, other)
    axes = rows[2].subplots(1, 3, sharey=True)
    for axis, arm in zip(axes, REGISTERED.arms, strict=True):
        numbers(axis, result, arm)
    axes[0].set(ylabel="deer", ylim=(0, 1.05 * max(line.get_ydata().max() for a in axes for line in a.lines)))
    with mpl.rc_context({"svg.hashsalt": "ecs-eco", "svg.fonttype": "none"}):
        figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)
    return path


def places(figure: Any, result: dict[str, Any]) -> None:
    """Plot the gain from running instead of walking against its cost and the range of sight, with a panel for
    each speed."""
    of, made = (
        result["config"]["approaches"],
        [e["result"]["grid"] for e in result["cases"] if e["case"]["arm"] == "approaches"],
    )
    values = {
        (p[0]["cost"], p[0]["sight"], p[0]["speed"]): np.mean([gain(q) for q in p])
        for p in zip(*made, strict=True)
    }
    axes = figure.subplots(1, len(of["speed"]), sharey=True)
    for axis, speed in zip(axes, of["speed"], strict=True):
        table = np.array([[values[cost, sight, speed] for cost in of["cost"]] for sight in of["sight"]])
        image = axis.imshow(table, cmap="RdBu_r", vmin=-1.5, vmax=1.5, origin="lower", aspect="auto")
        for i, line in enumerate(table):
            for j, v in enumerate(line):
                axis.text(
                    j,
                    i,
                    f"{v:+.2f}",
                    ha="center",
                    va="center",
                    fontsize=8,
                    color="white" if abs(v) > 0.9 else "black",
                )
        axis.set(
            title=f"wolves run {speed:g} m/s, deer 1 m/s",
            xlabel="cost of running [1/s]",
            xticks=range(len(of["cost"])),
            yticks=range(len(of["sight"])),
        )
        axis.set_xticklabels([f"{v:g}" for v in of["cost"]])
        axis.set_yticklabels([f"{v:g}" for v in of["sight"]])
        axis.title.set_fontsize(10)
    axes[0].set_ylabel("deer see wolves within [m]")
    figure.colorbar(image, ax=axes, label="happiness gained\nby running", shrink=0.9)


def curves(axis: Any, result: dict[str, Any], who: str, other: str) -> None:
    """Plot the share of running animals by distance to the nearest animal of the other species, with a line
    for each training seed."""
    for arm, colour in COLOURS.items():
        by: dict[int, list[Any]] = {}
        for e in result["cases"]:
            if e["case"]["arm"] == arm:
                by.setdefault(e["case"]["training"], []).append(e["result"]["pursuit"][who])
        counts = np.array([np.sum(of, axis=0) for of in by.values()])
        middle = (EDGES[:-1] + EDGES[1:]) / 2
        with np.errstate(invalid="ignore", divide="ignore"):
            shares = counts[:, :, 1] / counts[:, :, 0]
        axis.plot(middle, shares.T, color=colour, lw=0.6, alpha=0.5)
        axis.plot(middle, np.nanmean(shares, 0), color=colour, lw=2.2, label=SAYS[arm])
    names = {"deer": "deer", "wolf": "wolves"}
    axis.set(
        title=f"{names[who]} that run",
        xlabel=f"distance to the nearest {other} [m]",
        ylim=(0, 1),
        xlim=(0, EDGES[-1]),
    )
    axis.title.set_fontsize(10)
    axis.spines[["top", "right"]].set_visible(False)
    if who == "deer":
        axis.set_ylabel("share")
        axis.legend(frameon=False, fontsize=9)


def numbers(axis: Any, result: dict[str, Any], arm: str) -> None:
    """Plot an arm's number of deer over time for the first world seed, with a line for each training seed."""
    world = min(e["case"]["seed"] for e in result["cases"] if e["case"]["arm"] == arm)
    for e in result["cases"]:
        if e["case"]["arm"] == arm and e["case"]["seed"] == world:
            n = np.array([float(v) for v in e["result"]["series"]["deer"].split()])
            axis.plot(np.arange(len(n)) * BLOCK, n, color=COLOURS[arm], lw=0.9, alpha=0.8)
    axis.set(title=SAYS[arm], xlabel="tick [s]", xlim=(0, result["config"]["ticks"]))
    axis.title.set_fontsize(10)
    axis.spines[["top", "right"]].set_visible(False)


if __name__ == "__main__":
    draw_result(str(__doc__), "deer_that_flee", "deer_that_flee.svg", draw)
