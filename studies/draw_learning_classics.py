"""Draw docs/img/learning_classics.svg from studies/results/learning_classics.json: each experiment with and
without learning, over time, and for comparison the swarms that evolve in studies/results/swarms.json.

    python -m studies.draw_learning_classics
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from studies import fishing_for_size, prudence, swarms
from studies.common.figure import draw_result
from studies.learning_classics import of

LEARN, NOT, OTHER = "#d55e00", "#0072b2", "#999999"  # Okabe and Ito 2008


def draw(result: dict[str, Any], path: Path) -> Path:
    """Write the figure."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    figure, cases = Figure(figsize=(11, 6), layout="constrained"), result["cases"]
    axes = figure.subplot_mosaic([["periods", "weight", "yield"], ["intake", "eats", "near"]])
    periods(axes["periods"], cases)
    years, samples, looks = 1.0, prudence.EVERY, swarms.EVERY
    for arm, style in (("fished", "-"), ("not fished", "--")):
        for learns, colour in (("", NOT), (", learn", LEARN)):
            lines(axes["weight"], of(cases, arm + learns, "weight"), years, colour, style, arm + learns)
            if arm == "fished":
                lines(axes["yield"], of(cases, arm + learns, "yield"), years, colour, style, arm + learns)
    for arm, style in (("local", "-"), ("global", "--")):
        for learns, colour in (("", NOT), (", learn", LEARN)):
            lines(axes["intake"], of(cases, arm + learns, "intake"), samples, colour, style, arm + learns)
        lines(axes["eats"], of(cases, f"{arm}, learn", "eats"), samples, LEARN, style, f"{arm}, learn")
    for arm, style in (("confusion, learn", "-"), ("none, learn", "--"), ("confusion, no reward", ":")):
        lines(axes["near"], of(cases, arm, "near"), looks, LEARN, style, arm)
    evolved = json.loads((Path(__file__).parent / "results" / "swarms.json").read_text(encoding="utf-8"))
    lines(axes["near"], of(evolved["cases"], "confusion", "near"), looks, NOT, "-", "confusion, evolve")
    fishing = (fishing_for_size.BEFORE, fishing_for_size.AFTER)
    for name in ("weight", "yield"):
        axes[name].axvspan(*fishing, color="#eeeeee", zorder=0)
    axes["weight"].set(title="fish", xlabel="year (gray: fishery)", ylabel="weight [g]")
    axes["yield"].set(title="fish", xlabel="year (gray: fishery)", ylabel="catch [g]")
    axes["intake"].set(title="grazers", xlabel="tick", ylabel="inherited intake [1/tick]", ylim=(0, 1))
    axes["eats"].set(title="grazers", xlabel="tick", ylabel="share of ticks in which they eat", ylim=(0, 1))
    axes["near"].set(title="prey", xlabel="tick", ylabel="neighbors within 3 m")
    for name, axis in axes.items():
        axis.spines[["top", "right"]].set_visible(False)
        if name != "periods":
            low = {"loc": "lower right", "bbox_to_anchor": (1, 0.08)} if name == "near" else {}
            axis.legend(frameon=False, fontsize=8, **low)
    with mpl.rc_context({"svg.hashsalt": "ecs-eco", "svg.fonttype": "none"}):
        figure.savefig(path, metadata={"Date": None})
    return path


def periods(axis: Any, cases: list[dict[str, Any]]) -> None:
    """Draw the period of each run of the chemostat."""
    arms = ["one clone", "one clone, learn", "four clones", "four clones, learn"]
    for row, arm in enumerate(arms):
        values = list(of(cases, arm, "period").values())
        colour = LEARN if "learn" in arm else NOT
        axis.plot(values, np.full(len(values), row), "o", color=colour, alpha=0.4, ms=5, mew=0)
        axis.plot(np.median(values), row, "|", color=colour, ms=22, mew=2)
    axis.set(
        title="algae and rotifers", xlabel="period [ticks]", yticks=range(4), yticklabels=arms, xlim=(0, None)
    )
    axis.invert_yaxis()


def lines(axis: Any, runs: dict[int, Any], step: float, colour: str, style: str, label: str) -> None:
    """Draw the values of each run, and their mean over runs."""
    longest = max(map(len, runs.values()))
    values = np.array([np.pad(x, (0, longest - len(x)), constant_values=np.nan) for x in runs.values()]).T
    x = step * np.arange(1, longest + 1)
    axis.plot(x, values, color=colour, lw=0.4, ls=style, alpha=0.3)
    axis.plot(x, np.nanmean(values, axis=1), color=colour, lw=2, ls=style, label=label)


if __name__ == "__main__":
    draw_result(str(__doc__), "learning_classics", "learning_classics.svg", draw)
