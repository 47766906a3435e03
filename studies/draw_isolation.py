"""Draw docs/img/isolation.svg from studies/results/isolation.json: the diversity of genes and policies over
time on islands with no, little or much migration, and in one world with their total area.

    python -m studies.draw_isolation
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from studies.common.figure import draw_result
from studies.isolation import ARMS, numbers

COLOURS = dict(zip(ARMS, ("#0072b2", "#009e73", "#d55e00", "#555555"), strict=True))  # Okabe and Ito 2008
PANELS = {
    "H_S": "heterozygosity within an island, $H_S$",
    "H_T": "heterozygosity of all goats, $H_T$",
    "F_ST": "share between islands, $F_{ST}$",
    "policies between": "share of policy divergence\nbetween islands",
}


def curves(result: dict[str, Any], arm: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the ticks f64[k] at which a quantity was measured and its values f64[seeds, k].

    The single world was also measured at tick 0.
    """
    values = np.stack([numbers(e, name) for e in result["cases"] if e["case"]["arm"] == arm])
    config = result["config"]
    return config["ticks"] - config["sample"] * np.arange(values.shape[1])[::-1], values


def draw(result: dict[str, Any], path: Path) -> Path:
    """Write the figure: a line for each seed, and a thick line for each arm's mean."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.4, 5.4), layout="constrained")
    for axis, (name, title) in zip(figure.subplots(2, 2, sharex=True).flat, PANELS.items(), strict=True):
        for arm, colour in COLOURS.items():
            ticks, values = curves(result, arm, name)
            axis.plot(ticks, values.T, color=colour, lw=0.5, alpha=0.5)
            axis.plot(ticks, values.mean(axis=0), color=colour, lw=2.2, label=arm)
        axis.set(title=title, ylim=(min(0.0, axis.get_ylim()[0]), 1), xlim=(0, result["config"]["ticks"]))
        axis.title.set_fontsize(10)
        axis.spines[["top", "right"]].set_visible(False)
    for axis in figure.axes[2:]:
        axis.set_xlabel("tick [s]")
    figure.axes[0].legend(frameon=False, loc="lower left", fontsize=9)
    with mpl.rc_context({"svg.hashsalt": "ecs-eco", "svg.fonttype": "none"}):
        figure.savefig(path, metadata={"Date": None})
    return path


if __name__ == "__main__":
    draw_result(str(__doc__), "isolation", "isolation.svg", draw)
