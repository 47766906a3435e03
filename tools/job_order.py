"""Draw docs/img/job_order.svg: how many runs each point of a sweep has, wherever the sweep is cut.

    python tools/job_order.py

A plan of 6 points and 5 seeds is cut after each number of jobs, in the order of job numbers, in which earlier
versions ran them, and in the order of `ecs_eco.lab.work.evenly`.
"""

import sys
from collections import Counter
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))
from ecs_eco.lab.work import evenly  # noqa: E402

PICTURE = ROOT / "docs" / "img" / "job_order.svg"
POINTS, SEEDS = 6, 5
COLORS = ("#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#555555")  # Okabe and Ito 2008


def counts(order: list[tuple[int, int]]) -> list[list[int]]:
    """Return the number of runs at each point after each number of jobs, from 0 on."""
    done = (Counter(point for point, _ in order[:n]) for n in range(len(order) + 1))
    return [[of[point] for point in range(POINTS)] for of in done]


def draw(path: Path) -> Path:
    """Write the figure, with a line for each point."""
    jobs = [(point, seed) for point in range(POINTS) for seed in range(SEEDS)]
    figure = Figure(figsize=(8.5, 3.2), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    orders = {"earlier: point by point": jobs, "now: evenly": evenly(jobs, lambda job: job[0])}
    for axis, (title, order) in zip(axes, orders.items(), strict=True):
        for point, runs in enumerate(zip(*counts(order), strict=True)):
            shifted = [n + 0.05 * (point - (POINTS - 1) / 2) for n in runs]
            label = f"point {point + 1}"
            axis.step(range(len(runs)), shifted, where="post", color=COLORS[point], lw=1.6, label=label)
        axis.set_title(title, loc="left", fontsize=10, fontweight="bold")
        axis.set(xlabel="jobs done when the sweep is cut", xlim=(0, len(jobs)), yticks=range(SEEDS + 1))
        axis.spines[["top", "right"]].set_visible(False)
    axes[0].set_ylabel("runs at each point")
    axes[1].legend(frameon=False, fontsize=8, loc="upper left")
    with mpl.rc_context({"svg.hashsalt": "ecs-eco", "svg.fonttype": "none"}):
        figure.savefig(path, metadata={"Date": None})
    return path


if __name__ == "__main__":
    print(draw(PICTURE))
