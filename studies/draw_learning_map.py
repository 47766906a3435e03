"""Draw docs/img/learning_map.svg from studies/results/learning_map.json: where learning animals persist and cycle.

Rows: a quarter of the shipped ground and all of it. Left: the share of runs that persist, by both learning
rates. Middle: the share that cycle in order. Right, above: the share that persist among runs in which deer learn,
by the learning rate of wolves; below: at the shipped rates, by the area of the ground.
"""

from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from ecs_eco.analysis.palette import SAFE
from studies.common.figure import draw_result
from studies.learning_map import MAPS, RATES, REGISTERED, SHIPPED, Entry, share
from studies.lifelong import cycles, persists

NAMES = {"quarter": "a quarter of the ground", "shipped": "the shipped ground"}


def draw(record: dict[str, Any], path: Path) -> None:
    """Write a result's figure."""
    plt.rcParams["svg.hashsalt"] = "ecs-eco"
    entries = record["cases"]
    figure, axes = plt.subplots(2, 3, figsize=(11, 7), layout="constrained", width_ratios=(1, 1, 0.8))
    for line, arm in zip(axes, MAPS, strict=True):
        for ax, counts, name in zip(line, (persists, cycles), ("persist", "cycle in order"), strict=False):
            image = rates(ax, [e for e in entries if e["case"]["arm"] == arm], counts)
            ax.set_title(f"{NAMES[arm]}: {name}", loc="left", fontsize=9)
    figure.colorbar(image, ax=axes[:, 1], label="share of runs", shrink=0.7)
    grounds(axes[1, 2], entries)
    wolves(axes[0, 2], entries)
    figure.savefig(path, metadata={"Date": None})


def rates(ax: Any, entries: list[Entry], counts: Any) -> Any:
    """Draw the share of runs that count, by both learning rates; a frame marks the shipped rates."""
    table = [[share(entries, counts, deer=d, wolf=w) for d in RATES["deer"]] for w in RATES["wolf"]]
    image = ax.imshow(np.array(table), origin="lower", vmin=0, vmax=1, cmap="viridis")
    for y, line in enumerate(table):
        for x, value in enumerate(line):
            if np.isfinite(value):
                ax.text(
                    x,
                    y,
                    f"{value:.2g}",
                    ha="center",
                    va="center",
                    color="w" if value < 0.7 else "k",
                    fontsize=8,
                )
    place = [RATES["deer"].index(SHIPPED[0]) - 0.5, RATES["wolf"].index(SHIPPED[1]) - 0.5]
    ax.add_patch(plt.Rectangle(place, 1, 1, fill=False, color=SAFE[2][0], lw=2))
    ax.set(
        xticks=range(6), xticklabels=[text(v) for v in RATES["deer"]], xlabel="learning rate of deer [1e-3]"
    )
    ax.set(
        yticks=range(6), yticklabels=[text(v) for v in RATES["wolf"]], ylabel="learning rate of wolves [1e-3]"
    )
    return image


def text(rate: float) -> str:
    """Return a learning rate in thousandths as a label."""
    return f"{rate * 1000:g}" if rate else "frozen"


def wolves(ax: Any, entries: list[Entry]) -> None:
    """Draw the share of runs that persist if deer learn, over all their rates, by the learning rate of wolves."""
    for (hue, marker), arm in zip(((SAFE[1][0], "s"), (SAFE[0][0], "o")), MAPS, strict=True):
        of = [share(entries, arm=arm, wolf=rate, deer=RATES["deer"][1:]) for rate in RATES["wolf"]]
        ax.plot(of, marker=marker, color=hue, label=NAMES[arm])
    ax.set(
        xticks=range(6), xticklabels=[text(v) for v in RATES["wolf"]], xlabel="learning rate of wolves [1e-3]"
    )
    ax.set(ylabel="share of runs that persist", ylim=(-0.05, 1.05))
    ax.set_title("deer learn, at any rate", loc="left", fontsize=9)
    ax.legend(frameon=False, fontsize=8, loc="lower right")


def grounds(ax: Any, entries: list[Entry]) -> None:
    """Draw the share of runs that persist at the shipped rates, by the area of the ground."""
    deer, wolf = SHIPPED
    area = {arm: (says.get("space.size", [240.0])[0] / 240) ** 2 for arm, says in REGISTERED.arms.items()}
    arms = sorted(area, key=lambda arm: area[arm])
    at_rates = [e for e in entries if (e["case"]["deer"], e["case"]["wolf"]) == (deer, wolf)]
    ax.plot([area[a] for a in arms], [share(at_rates, arm=a) for a in arms], "o-", color=SAFE[0][0])
    ax.set(xscale="log", xlabel="area (shipped: 1)", ylabel="share of runs that persist", ylim=(-0.05, 1.05))
    ax.set_xticks([area[a] for a in arms], [f"{area[a]:.2g}" for a in arms], minor=False)
    ax.set_xticks([], minor=True)
    ax.set_title("shipped rates", loc="left", fontsize=9)


if __name__ == "__main__":
    draw_result(str(__doc__), "learning_map", "learning_map.svg", draw)
