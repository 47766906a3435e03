"""Draw docs/img/individual_brains.svg from studies/results/individual_brains.json: one network for each animal, or
for each species.

Left: numbers of deer in a run with individual networks, in the run with shared ones of the same seeds, and in a run
in which individual networks are not inherited. Right: how much deer vary in number in each run.
"""

from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from ecs_eco.analysis.palette import SAFE
from studies.common.figure import draw_result, series

COLORS = {"individual": SAFE[0][0], "shared": SAFE[6][0], "not inherited": SAFE[2][0]}


def draw(record: dict[str, Any], path: Path) -> None:
    """Write a result's figure."""
    plt.rcParams["svg.hashsalt"] = "ecs-eco"
    runs = {arm: [c["result"] for c in record["cases"] if c["case"]["arm"] == arm] for arm in COLORS}
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 3.6), layout="constrained", width_ratios=(2.2, 1))
    for arm in ("shared", "individual", "not inherited"):
        for result in runs[arm][:1]:
            left.plot(*series(result, "deer"), color=COLORS[arm], lw=1.2, label=arm)
    left.set(xlim=(0, None), ylim=(0, None), xlabel="1,000 ticks", ylabel="deer")
    left.legend(ncols=3, frameon=False, loc="lower right", bbox_to_anchor=(1, 1))
    left.set_title("the first run of each arm", loc="left", fontsize=9)
    for place, arm in enumerate(("individual", "shared")):
        values = [r["variation"]["deer"] for r in runs[arm] if r["persisted"]]
        beside = place + np.linspace(-0.15, 0.15, len(values))
        right.plot(beside, values, "o", ms=4, color=COLORS[arm], mew=0, alpha=0.8)
    right.set(xlim=(-0.5, 1.5), ylim=(0, None), ylabel="coefficient of variation of deer")
    right.set_xticks(
        [0, 1],
        [
            f"{arm}:\n{sum(r['persisted'] for r in runs[arm])} of {len(runs[arm])} persist"
            for arm in ("individual", "shared")
        ],
    )
    right.set_title("each dot is a run", loc="left", fontsize=9)
    figure.savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    draw_result(str(__doc__), "individual_brains", "individual_brains.svg", draw)
