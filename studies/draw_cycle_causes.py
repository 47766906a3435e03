"""Draw docs/img/cycle_causes.svg from studies/results/cycle_causes.json: for each arm, the share of runs that
persist and cycle in the best world of its search, and the outcomes of nearby worlds.

    python -m studies.draw_cycle_causes
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from studies.common.figure import draw_result
from studies.cycle_causes import REGISTERED, shares

SAYS = {
    "learned": "learned",
    "blind": "learned,\nblind to wolves",
    "slow": "learned,\nunable to run",
    "grazer": "scripted,\nno flight",
    "runner": "scripted,\nflees",
    "random": "random",
}
# persists and cycles, only persists, or the first species to go extinct; colors: Okabe and Ito (2008)
OUTCOMES = {
    "c": ("persist and cycle", "#009e73"),
    "p": ("persist", "#56b4e9"),
    "w": ("wolves die out first", "#999999"),
    "d": ("deer die out first", "#e69f00"),
    "g": ("grass dies out first", "#d55e00"),
}


def draw(result: dict[str, Any], path: Path) -> Path:
    """Write the figure."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    arms = {e["case"]["arm"]: e["result"] for e in result["cases"]}
    names = [name for name in REGISTERED.arms if name in arms]
    figure = Figure(figsize=(11, 5.4), layout="constrained")
    rows = figure.subfigures(2, 1, height_ratios=(1, 1.25))
    bars(rows[0].subplots(), {name: arms[name]["lives"] for name in names})
    axes = rows[1].subplots(1, len(names), sharey=True, squeeze=False)[0]
    for axis, name in zip(axes, names, strict=True):
        around(axis, arms[name]["map"], result["config"]["factors"])
    rows[1].suptitle(
        "worlds near each arm's best: birth rates of deer (up) and wolves (across) relative to the best",
        fontsize=10,
    )
    marks = [mpl.patches.Patch(color=colour, label=label) for label, colour in OUTCOMES.values()]
    rows[1].legend(handles=marks, loc="outside lower center", ncols=len(marks), frameon=False, fontsize=9)
    with mpl.rc_context({"svg.hashsalt": "ecs-eco", "svg.fonttype": "none"}):
        figure.savefig(path, metadata={"Date": None})
    return path


def bars(axis: Any, lives: dict[str, list[dict[str, Any]]]) -> None:
    """Plot the shares of runs that persist and of runs that cycle, with a point for each training seed."""
    for at, of in enumerate(lives.values()):
        for outcome, what in (("p", "persisted"), ("c", "cycled")):
            label, colour = OUTCOMES[outcome]
            axis.bar(
                at,
                np.mean([life[what] for life in of]),
                width=0.6,
                color=colour,
                label=label if at == 0 else None,
            )
        each = shares(of)
        axis.plot(
            at + np.linspace(-0.2, 0.2, len(each)),
            each,
            "o",
            color="black",
            ms=4,
            label="each training seed" if at == 0 else None,
        )
    axis.set(ylim=(0, 1.03), ylabel="share of runs")
    axis.set_xticks(range(len(lives)), [SAYS[name] for name in lives], fontsize=9)
    axis.spines[["top", "right"]].set_visible(False)
    axis.legend(frameon=False, fontsize=9, loc="upper left", bbox_to_anchor=(1, 1))


def around(axis: Any, letters: list[str], factors: list[float]) -> None:
    """Plot the outcome of each world around the best one."""
    keys = list(OUTCOMES)
    image = np.array(
        [
            [
                tuple(int(OUTCOMES[c][1][i : i + 2], 16) for i in (1, 3, 5)) if c in keys else (255, 255, 255)
                for c in row
            ]
            for row in letters
        ],
        np.uint8,
    )
    axis.imshow(image, origin="lower")
    axis.set_xticks(range(len(factors)), [f"{f:g}" for f in factors], fontsize=7)
    axis.set_yticks(range(len(factors)), [f"{f:g}" for f in factors], fontsize=7)
    for i, row in enumerate(letters):
        for j, letter in enumerate(row):
            axis.text(j, i, letter, ha="center", va="center", fontsize=8)


if __name__ == "__main__":
    draw_result(str(__doc__), "cycle_causes", "cycle_causes.svg", draw)
