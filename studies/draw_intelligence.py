"""Draw docs/img/intelligence.svg from studies/results/intelligence.json: the map of learning rates, learning rates
by what both pasts predict, and the effect of an informative life in all arms.

    python -m studies.draw_intelligence
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from studies.common.figure import draw_result
from studies.intelligence import BETWEEN, CONTROLS, HUNTED, LINE, WITHIN, effect, pasts, values

SMALLEST = 0.001  # added to learning rates before their logarithm


def draw(result: dict[str, Any], path: Path) -> Path:
    """Write the figure; points are seeds, or the means of eight seeds."""
    import matplotlib as mpl
    import numpy as np
    from matplotlib.figure import Figure

    cases = result["cases"]
    figure = Figure(figsize=(13, 4.6), layout="constrained")
    grid, against, arms = figure.subplots(1, 3, width_ratios=(1, 0.9, 1.2))
    rates = np.array(
        [[np.mean(list(values(cases, "map", (w, b)).values())) for b in BETWEEN] for w in WITHIN]
    )
    image = grid.imshow(rates, origin="lower", cmap="viridis")
    for (y, x), rate in np.ndenumerate(rates):
        dark = rate < (rates.min() + rates.max()) / 2
        text = f"{max(10**rate - SMALLEST, 0):.3f}"
        grid.text(x, y, text, ha="center", va="center", color="w" if dark else "k", fontsize=8)
    grid.set(xticks=range(5), xticklabels=BETWEEN, xlabel="probability of change between generations")
    grid.set(yticks=range(5), yticklabels=WITHIN, ylabel="probability of change per tick of life")
    figure.colorbar(image, ax=grid, shrink=0.7, label="log10(learning rate + 0.001)")
    gaps = [[np.subtract(*pasts(w, b)) for b in BETWEEN] for w in WITHIN]
    against.scatter(gaps, rates, color="#0072b2", s=22)
    against.set(
        xlabel="what life predicts minus what the line predicts", ylabel="log10(learning rate + 0.001)"
    )
    effects = {"costs": effect(cases, "map")} | {arm: effect(cases, arm) for arm in CONTROLS}
    hunted = {arm: values(cases, arm, LINE) for arm in HUNTED}
    others = hunted["hunters evolve"]
    effects["hunters learn,\nminus evolve"] = {s: hunted["hunters learn"][s] - others[s] for s in others}
    for place, by_seed in enumerate(effects.values()):
        seeds = np.array(list(by_seed.values()))
        arms.scatter(place + np.linspace(-0.15, 0.15, seeds.size), seeds, s=12, color="#999999")
        arms.plot([place - 0.25, place + 0.25], [seeds.mean()] * 2, color="#d55e00", lw=2.5)
    arms.axhline(0, color="#cccccc", lw=0.8, zorder=0)
    arms.set_xticks(range(len(effects)), list(effects), fontsize=8, rotation=25)
    arms.set(ylabel="effect of an informative life")
    for axis in (against, arms):
        axis.spines[["top", "right"]].set_visible(False)
    with mpl.rc_context({"svg.hashsalt": "ecs-eco", "svg.fonttype": "none"}):
        figure.savefig(path, metadata={"Date": None})
    return path


if __name__ == "__main__":
    draw_result(str(__doc__), "intelligence", "intelligence.svg", draw)
