"""Draw docs/img/fishing_for_size.svg from studies/results/fishing_for_size.json: weight and catch by year, for each
choice of the fish that are caught.

    python -m studies.draw_fishing_for_size
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from studies.common.figure import draw_result
from studies.fishing_for_size import AFTER, BEFORE, by_seed

ARMS = {  # Okabe and Ito 2008; dashed: sizes are drawn at birth
    "largest": ("#d55e00", "-"),
    "smallest": ("#0072b2", "-"),
    "random": ("#009e73", "-"),
    "none": ("#555555", "-"),
    "largest drawn": ("#d55e00", "--"),
    "smallest drawn": ("#0072b2", "--"),
}


def draw(result: dict[str, Any], path: Path) -> Path:
    """Write the figure: a thin line for each seed, and a thick line for each arm's mean."""
    import matplotlib as mpl
    import numpy as np
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4.2), layout="constrained")
    weights, catches = figure.subplots(1, 2)
    for arm, (colour, style) in ARMS.items():
        for axis, name, years in ((weights, "weight", slice(None)), (catches, "yield", slice(BEFORE, AFTER))):
            values = np.array(list(by_seed(result["cases"], arm, name).values())).T[years]
            year = np.arange(31)[years]
            if name == "yield" and arm == "none":
                continue
            axis.plot(year, values, color=colour, lw=0.4, ls=style, alpha=0.4)
            axis.plot(year, values.mean(1), color=colour, lw=2, ls=style, label=arm)
    weights.axvspan(BEFORE, AFTER - 1, color="#eeeeee", zorder=0)
    weights.text(BEFORE + 0.3, 1.85, "fishing", fontsize=8, color="#777777")
    weights.set(yscale="log", ylim=(1.8, 11), xlabel="year", ylabel="inherited adult weight of newborns [g]")
    weights.set_yticks([2, 4, 8], ["2", "4", "8"])
    weights.minorticks_off()
    weights.legend(frameon=False, fontsize=8, loc="upper left")
    catches.set(ylim=(0, None), xlabel="year", ylabel="catch [g per year]")
    for axis in (weights, catches):
        axis.spines[["top", "right"]].set_visible(False)
    with mpl.rc_context({"svg.hashsalt": "ecs-eco", "svg.fonttype": "none"}):
        figure.savefig(path, metadata={"Date": None})
    return path


if __name__ == "__main__":
    draw_result(str(__doc__), "fishing_for_size", "fishing_for_size.svg", draw)
