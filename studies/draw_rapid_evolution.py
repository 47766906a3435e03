"""Draw docs/img/rapid_evolution.svg from studies/results/rapid_evolution.json: algae, rotifers and the defense of
algae over time in each arm, and the lag and period of all runs.

    python -m studies.draw_rapid_evolution
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from studies.common.figure import draw_result
from studies.rapid_evolution import EVERY

ARMS = {"clone": "one clone", "clones": "four clones", "drawn": "four clones, drawn at birth"}
COLOURS = dict(zip(ARMS, ("#0072b2", "#d55e00", "#555555"), strict=True))  # Okabe and Ito 2008
LINES = {"alga": ("#009e73", "algae"), "rotifer": ("#cc79a7", "rotifers")}
SHOWN = slice(1200 // EVERY, 2400 // EVERY)


def draw(result: dict[str, Any], path: Path) -> Path:
    """Write the figure: the first seed's numbers in each arm, and all runs that have a period."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 5.6), layout="constrained")
    axes = figure.subplots(2, 2)
    for axis, (arm, title) in zip(axes.flat[:3], ARMS.items(), strict=True):
        first = next(e["result"] for e in result["cases"] if e["case"]["arm"] == arm)
        series = {name: np.array(first[name].split(), float) for name in (*LINES, "wall")}
        tick = EVERY * np.arange(1, len(series["wall"]) + 1)
        for name, (colour, label) in LINES.items():
            axis.plot(tick[SHOWN], series[name][SHOWN], color=colour, lw=1.4, label=label)
        defence = axis.twinx()
        defence.plot(tick[SHOWN], series["wall"][SHOWN], color="#999999", lw=1, ls="--", label="defense")
        defence.set(ylim=(-0.02, 1.0), ylabel="share of bites that fail")
        axis.set(title=title, yscale="log", ylim=(10, 10_000), xlabel="tick [2 h]", ylabel="number")
        handles = [*axis.get_lines(), *defence.get_lines()]
        if arm == "clone":
            axis.legend(handles=handles, frameon=False, fontsize=8, loc="upper right", ncols=3)
    last = axes.flat[3]
    for arm, title in ARMS.items():
        of = [
            e["result"] for e in result["cases"] if e["case"]["arm"] == arm and e["result"]["lag"] is not None
        ]
        for cycles, face in ((True, COLOURS[arm]), (False, "none")):
            runs = [r for r in of if r["cycles"] is cycles]
            x, y = ([r[name] for r in runs] for name in ("period", "lag"))
            last.scatter(x, y, s=26, facecolor=face, edgecolor=COLOURS[arm], label=title if runs else None)
    for lag, note in ((0.25, "a quarter of a period"), (0.5, "antiphase")):
        last.axhline(lag, color="#bbbbbb", lw=0.8, zorder=0)
        last.text(
            0.99,
            lag + 0.005,
            note,
            fontsize=8,
            color="#777777",
            ha="right",
            transform=last.get_yaxis_transform(),
        )
    last.set(title="all runs (hollow: no cycle above noise)", xlabel="period [ticks]", ylim=(0.2, 0.54))
    last.set_ylabel("lag of rotifers behind algae [periods]")
    last.legend(frameon=False, fontsize=8, loc="center right")
    with mpl.rc_context({"svg.hashsalt": "ecs-eco", "svg.fonttype": "none"}):
        figure.savefig(path, metadata={"Date": None})
    return path


if __name__ == "__main__":
    draw_result(str(__doc__), "rapid_evolution", "rapid_evolution.svg", draw)
