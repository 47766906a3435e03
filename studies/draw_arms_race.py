"""Draw docs/img/arms_race.svg from studies/results/arms_race.json: deer and wolf genes over time, and kills
for each pair of sampling times.

    python -m studies.draw_arms_race
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from studies.arms_race import REGISTERED
from studies.common.figure import draw_result

COLOURS = {"both": "#009e73", "genes": "#0072b2", "drift": "#999999", "no hunters": "#d55e00"}
SAYS = {
    "both": "genes and learning",
    "genes": "genes only",
    "learning": "learning only",
    "drift": "neutral genes",
    "no hunters": "genes, no wolves",
}
PANELS = {
    ("deer", "pace"): "pace of deer",
    ("deer", "sight"): "deer see wolves within [m]",
    ("wolf", "sight"): "wolves see deer within [m]",
}


def draw(result: dict[str, Any], path: Path) -> Path:
    """Write the figure: genes in the top row, with one line per training seed; kills by sampling time in the
    bottom row."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 6.6), layout="constrained")
    above, below = figure.subfigures(2, 1)
    axes = above.subplots(1, 3)
    for axis, ((species, gene), title) in zip(axes, PANELS.items(), strict=True):
        for arm, colour in COLOURS.items():
            if (arm, species) != ("no hunters", "wolf"):
                courses(axis, result, arm, species, gene, colour)
        axis.set(
            title=title,
            xlabel="tick [s]",
            ylim=result["config"]["genes"][species][gene],
            xlim=(0, result["config"]["ticks"]),
        )
        axis.title.set_fontsize(10)
        axis.spines[["top", "right"]].set_visible(False)
    axes[1].legend(frameon=False, fontsize=8, loc="lower left")
    meetings(below, result)
    with mpl.rc_context({"svg.hashsalt": "ecs-eco", "svg.fonttype": "none"}):
        figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)
    return path


def courses(axis: Any, result: dict[str, Any], arm: str, species: str, gene: str, colour: str) -> None:
    """Plot a gene's mean over time in each of an arm's persisting runs, and the mean over those runs."""
    lines = [
        [t[species][gene][0] for t in e["result"]["genes"]]
        for e in result["cases"]
        if e["case"]["arm"] == arm and e["result"]["persisted"]
    ]
    if lines:
        ticks = np.arange(len(lines[0])) * result["config"]["every"]
        axis.plot(ticks, np.transpose(lines), color=colour, lw=0.5, alpha=0.5)
        axis.plot(ticks, np.mean(lines, 0), color=colour, lw=2.2, label=SAYS[arm])


def meetings(figure: Any, result: dict[str, Any]) -> None:
    """Plot geometric means over runs of kills per wolf per 1,000 s, by the sampling times of hunters and
    prey."""
    arms = [arm for arm, of in REGISTERED.arms.items() if of.get("tests")]
    tables = {
        arm: [
            e["result"]["tests"] for e in result["cases"] if e["case"]["arm"] == arm and e["result"]["tests"]
        ]
        for arm in arms
    }
    means = {arm: 1000 * np.exp(np.mean(of, 0)) for arm, of in tables.items() if of}
    top = max(float(of.max()) for of in means.values())
    axes = figure.subplots(1, len(arms), sharey=True)
    for axis, arm in zip(axes, arms, strict=True):
        if arm not in means:
            continue
        times = np.linspace(0, result["config"]["ticks"], len(means[arm]))
        image = axis.imshow(means[arm], cmap="viridis", vmin=0, vmax=top, origin="lower", aspect="auto")
        for i, line in enumerate(means[arm]):
            for j, v in enumerate(line):
                axis.text(
                    j,
                    i,
                    f"{v:.1f}",
                    ha="center",
                    va="center",
                    fontsize=9,
                    color="white" if v < 0.6 * top else "black",
                )
        axis.set(
            title=f"{SAYS[arm]} ({len(tables[arm])} runs)",
            xlabel="prey from tick",
            xticks=range(len(times)),
            yticks=range(len(times)),
        )
        axis.set_xticklabels([f"{t:,.0f}" for t in times])
        axis.set_yticklabels([f"{t:,.0f}" for t in times])
        axis.title.set_fontsize(10)
    axes[0].set_ylabel("hunters from tick")
    figure.colorbar(image, ax=axes, label="kills per wolf\nin 1,000 s", shrink=0.9)


if __name__ == "__main__":
    draw_result(str(__doc__), "arms_race", "arms_race.svg", draw)
