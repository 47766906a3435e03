"""Draw docs/img/goats_factorial.svg from studies/results/goats_factorial.json: each gene's selection
coefficient for each combination of learning and inheritance, and whether newborns would eat yellow grass.

    python -m studies.draw_goats_factorial
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from studies.common.figure import draw_result
from studies.common.selection import mean_interval
from studies.goats_factorial import REGISTERED

COLOURS = {True: "#0072b2", False: "#d55e00"}  # learning, frozen (Okabe and Ito 2008)
MARKERS = {True: "o", False: "s"}
INHERIT = {"none": "nothing", "birth": "birth\nweights", "learned": "learned\nweights"}
TITLES = {
    "red": "red (deadly: block eating)",
    "yellow": "yellow (costly: block eating)",
    "green": "green (food: block eating)",
    "blue": "blue (neutral)",
}


def draw(result: dict[str, Any], path: Path) -> Path:
    """Write the figure: a point for each run, and means over runs with 95% intervals."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 5.6), layout="constrained")
    axes = figure.subplots(2, 3)
    for axis, (gene, title) in zip(axes.flat, TITLES.items(), strict=False):
        panel(axis, result, True, lambda r, gene=gene: r["s"][gene])
        axis.axhline(0, color="grey", lw=0.8, zorder=0)
        axis.set_title(title, loc="left", fontsize=10)
    for axis, genes in zip(axes.flat[4:], (True, False), strict=True):
        panel(axis, result, genes, lambda r: r["eat yellow"])
        axis.set(ylim=(0, 1), ylabel="probability")
        axis.set_title(
            f"newborns that eat yellow, {'with' if genes else 'no'} reflex genes", loc="left", fontsize=10
        )
    for axis in axes[:, 0]:
        axis.set_ylabel("selection coefficient\nper generation")
    axes[0, 0].legend(frameon=False, fontsize=9)
    figure.supxlabel("what a kid inherits", fontsize=10)
    with mpl.rc_context({"svg.hashsalt": "ecs-eco", "svg.fonttype": "none"}):
        figure.savefig(path, metadata={"Date": None})
    return path


def panel(axis: Any, result: dict[str, Any], genes: bool, value: Any) -> None:
    """Plot each run's value by kind of inheritance, for goats that learn and goats that do not."""
    for learn, colour in COLOURS.items():
        for at, inherit in enumerate(INHERIT):
            name = next(
                name
                for name, of in REGISTERED.arms.items()
                if (of["inherit"], of["learn"], of["genes"]) == (inherit, learn, genes)
            )
            values = [
                v
                for e in result["cases"]
                if e["case"]["arm"] == name
                if (v := value(e["result"])) is not None
            ]
            if not values:
                continue
            x = at + (-0.16 if learn else 0.16)
            mean, low, high = mean_interval(values)
            axis.plot(x + np.linspace(-0.07, 0.07, len(values)), values, ".", color=colour, ms=3, alpha=0.5)
            axis.errorbar(
                x,
                mean,
                [[mean - low], [high - mean]] if len(values) > 1 else None,
                fmt=MARKERS[learn],
                color=colour,
                capsize=4,
                ms=7,
                label=("learn" if learn else "do not learn") if at == 0 else None,
            )
    axis.set_xticks(range(len(INHERIT)), list(INHERIT.values()), fontsize=9)
    axis.spines[["top", "right"]].set_visible(False)


if __name__ == "__main__":
    draw_result(str(__doc__), "goats_factorial", "goats_factorial.svg", draw)
