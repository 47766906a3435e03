"""Draw docs/img/never_settling.svg from studies/results/never_settling.json: 100,000 ticks of learning.

Left: the number of runs in which deer and wolves live. Middle: the distance of policies by the time between them,
in runs that last. Right: deer that a wolf of one time catches among deer of another, relative to the mean of each
run, on average over these runs.
"""

from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from studies.common.figure import draw_result
from studies.draw_lifelong import COLORS
from studies.never_settling import LEARNERS, STUDY

EVERY = STUDY.config["every"] / 1000  # [1,000 ticks] between stored policies


def draw(record: dict[str, Any], path: Path) -> None:
    """Write a result's figure."""
    plt.rcParams["svg.hashsalt"] = "ecs-eco"
    results = [c["result"] for c in record["cases"]]
    whole = [r for r in results if r["persisted"]]
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
    lived(left, [r["lived"] / 1000 for r in results])
    if whole:
        apart(middle, whole)
        figure.colorbar(caught(right, whole), ax=right, label="catches, relative to the run's mean")
    figure.savefig(path, metadata={"Date": None})


def lived(ax: Any, ends: list[float]) -> None:
    """Plot the number of runs in which deer and wolves still live."""
    last = STUDY.config["ticks"] / 1000
    t = sorted([0.0, *(end for end in ends if end < last), last])
    ax.step(t, [sum(end > at or end >= last for end in ends) for at in t], where="post", color="k")
    ax.set(xlim=(0, last), ylim=(0, len(ends) + 0.5), xlabel="1,000 ticks", ylabel="runs")
    ax.yaxis.get_major_locator().set_params(integer=True)
    ax.set_title("deer and wolves live", loc="left", fontsize=9)


def apart(ax: Any, results: list[dict[str, Any]]) -> None:
    """Plot the distance of policies by the time between them: each run, and the mean."""
    for name in LEARNERS:
        matrices = [np.array(r["distances"][name]) for r in results]
        lags = np.arange(1, len(matrices[0]))
        each = np.array([[np.diag(matrix, lag).mean() for lag in lags] for matrix in matrices])
        for line in each:
            ax.plot(lags * EVERY, line, color=COLORS[name], lw=0.6, alpha=0.5)
        ax.plot(lags * EVERY, each.mean(0), color=COLORS[name], lw=2, label=name)
    ax.set(xlim=(0, None), ylim=(0, None), xlabel="1,000 ticks apart", ylabel="distance of policies [nats]")
    ax.legend(frameon=False, loc="lower right")
    ax.set_title("how far policies are apart", loc="left", fontsize=9)


def caught(ax: Any, results: list[dict[str, Any]]) -> Any:
    """Draw catches by the time of wolves and of deer, as the ratio to the mean of each run."""
    tests = np.array([r["tests"] for r in results])
    ratio = np.exp((tests - tests.mean((1, 2), keepdims=True)).mean(0))
    low, high = EVERY / 2, (len(ratio) + 0.5) * EVERY
    image = ax.imshow(ratio, origin="lower", extent=(low, high, low, high), cmap="viridis")
    ax.set(xlabel="time of deer [1,000 ticks]", ylabel="time of wolves [1,000 ticks]")
    ax.set_title("catches", loc="left", fontsize=9)
    return image


if __name__ == "__main__":
    draw_result(str(__doc__), "never_settling", "never_settling.svg", draw)
