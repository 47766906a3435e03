"""Draw docs/img/outside.png from studies/results/outside.json: deer intake as each learner learns.

python -m studies.draw_outside
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from studies.common.figure import draw_result

COLOURS = {
    "built-in PPO": "#1b1b1b",
    "SB3 on slots": "#2a78b5",
    "PPO on PettingZoo": "#c4572a",
    "function": "#4d9221",
    "chance": "#999999",
}


def curves(result: dict[str, Any]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return, for each arm, the transitions f64[k] and the intake f64[seeds, k]."""
    out = {}
    for arm in COLOURS:
        runs = [c["result"]["curve"] for c in result["cases"] if c["case"]["arm"] == arm]
        k = min(map(len, runs))
        points = np.array([run[:k] for run in runs], float)
        out[arm] = points[:, :, 0].mean(axis=0), points[:, :, 1]
    return out


def draw(result: dict[str, Any], path: Path) -> Path:
    """Write the figure: medians over seeds, and ranges."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 3.8), layout="constrained")
    ax = figure.subplots()
    most = result["config"]["steps"] / 1000
    for arm, (steps, intake) in curves(result).items():
        if len(steps) == 1:
            ax.axhline(np.median(intake), color=COLOURS[arm], ls="--", lw=1.2, label=arm)
            continue
        ax.fill_between(
            steps / 1000, intake.min(axis=0), intake.max(axis=0), color=COLOURS[arm], alpha=0.15, lw=0
        )
        ax.plot(steps / 1000, np.median(intake, axis=0), color=COLOURS[arm], lw=1.8, label=arm)
    ax.set(
        xlim=(0, most),
        ylim=(0, None),
        xlabel="deer transitions [thousands]",
        ylabel="energy intake\nper deer per 100 ticks",
    )
    ax.legend(frameon=False, loc="center right")
    ax.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=140)
    return path


if __name__ == "__main__":
    draw_result(str(__doc__), "outside", "outside.png", draw)
