"""Draw docs/img/prudence.svg from studies/results/prudence.json: intake over time, selection within and among
patches, and maps of intake at the end of the first seed's runs.

    python -m studies.draw_prudence
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from studies.common.figure import draw_result
from studies.common.training_seeds import interval
from studies.prudence import EVERY, PATCH, measured

ARMS = {  # Okabe and Ito 2008; dashed: intakes are drawn at birth
    "local": ("#0072b2", "-"),
    "global": ("#d55e00", "-"),
    "shuffled": ("#009e73", "-"),
    "local drawn": ("#0072b2", "--"),
    "global drawn": ("#d55e00", "--"),
}


def draw(result: dict[str, Any], path: Path) -> Path:
    """Write the figure."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    figure, cases = Figure(figsize=(11, 6), layout="constrained"), result["cases"]
    axes = figure.subplot_mosaic(
        [["time", "local", "global"], ["selection", "shuffled", "local drawn"]], width_ratios=[1.6, 1, 1]
    )
    for arm, (colour, style) in ARMS.items():
        runs = np.array([text.split() for text in measured(cases, arm, "intake")], float).T
        tick = EVERY * np.arange(1, len(runs) + 1)
        axes["time"].plot(tick, runs, color=colour, lw=0.4, ls=style, alpha=0.4)
        axes["time"].plot(tick, np.exp(np.log(runs).mean(1)), color=colour, lw=2, ls=style, label=arm)
    axes["time"].set(ylim=(0, 1), xlabel="tick", ylabel="mean intake [1/tick]")
    axes["time"].legend(frameon=False, fontsize=8, loc="lower left", bbox_to_anchor=(0.3, 0), ncols=2)
    effects(axes["selection"], cases)
    shades = mpl.colormaps["viridis_r"].with_extremes(bad="#eeeeee")
    for arm in ("local", "global", "shuffled", "local drawn"):
        values = np.array(measured(cases, arm, "map")[0].split(), float)
        side = round(values.size**0.5)
        grid = np.ma.masked_equal(values.reshape(side, side).T, 0)
        image = axes[arm].imshow(
            grid, origin="lower", cmap=shades, vmin=0.1, vmax=1, extent=(0, side * PATCH) * 2
        )
        axes[arm].set(title=arm, xlabel="m", xticks=[0, 50, 100], yticks=[0, 50, 100])
    bar = figure.colorbar(
        image, ax=[axes[arm] for arm in ("local", "global", "shuffled", "local drawn")], shrink=0.7
    )
    bar.set_label("mean intake of a patch's grazers (gray: none)")
    for name in ("time", "selection"):
        axes[name].spines[["top", "right"]].set_visible(False)
    with mpl.rc_context({"svg.hashsalt": "ecs-eco", "svg.fonttype": "none"}):
        figure.savefig(path, metadata={"Date": None})
    return path


def effects(axis: Any, cases: list[dict[str, Any]]) -> None:
    """Draw the mean and the 95% interval of selection within and among patches for each arm."""
    for i, (name, marker) in enumerate((("within", "o"), ("among", "s"))):
        for row, (arm, (colour, _)) in enumerate(ARMS.items()):
            mean, low, high = interval(measured(cases, arm, name).tolist())
            face = "white" if "drawn" in arm else colour
            place = row + 0.3 * i - 0.15
            axis.plot([low, high], [place, place], color=colour, lw=1.5, zorder=1)
            axis.plot(mean, place, marker, color=colour, markerfacecolor=face, ms=6)
        axis.plot([], [], marker, color="#555555", ls="", label=f"{name} patches")
    axis.axvline(0, color="#bbbbbb", lw=0.8, zorder=0)
    axis.set(
        yticks=range(len(ARMS)), yticklabels=list(ARMS), xlabel="selection per unit of ln intake in 30 ticks"
    )
    axis.invert_yaxis()
    axis.legend(frameon=False, fontsize=8, loc="lower left")


if __name__ == "__main__":
    draw_result(str(__doc__), "prudence", "prudence.svg", draw)
