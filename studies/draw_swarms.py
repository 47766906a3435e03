"""Draw docs/img/swarms.svg from studies/results/swarms.json: neighbors, attraction and predators' field of view
over time, with and without confusion.

    python -m studies.draw_swarms
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from studies.common.figure import draw_result
from studies.swarms import EVERY

ARMS = {  # Okabe and Ito 2008; dashed: predators inherit their field of view
    "confusion": ("#d55e00", "-"),
    "none": ("#0072b2", "-"),
    "drawn": ("#009e73", "-"),
    "no predators": ("#555555", "-"),
    "confusion view": ("#d55e00", "--"),
    "none view": ("#0072b2", "--"),
}
PANELS = {  # measure, axis label, arms
    "near": ("neighbors within 3 m", list(ARMS)[:5]),
    "attraction": ("attraction to the side with more prey", list(ARMS)[:4]),
    "view": ("predators' field of view [rad]", list(ARMS)[4:]),
}


def draw(result: dict[str, Any], path: Path) -> Path:
    """Write the figure: a thin line for each seed, and a thick line for each arm's mean."""
    import matplotlib as mpl
    import numpy as np
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 3.8), layout="constrained")
    for axis, (name, (label, arms)) in zip(figure.subplots(1, 3), PANELS.items(), strict=True):
        for arm in arms:
            color, style = ARMS[arm]
            own = [e["result"][name] for e in result["cases"] if e["case"]["arm"] == arm]
            values = np.array([line.split() for line in own], float).T
            tick = EVERY * np.arange(1, len(values) + 1)
            mean = np.exp(np.log(values).mean(1)) if name == "near" else values.mean(1)
            axis.plot(tick, values, color=color, lw=0.4, ls=style, alpha=0.4)
            axis.plot(tick, mean, color=color, lw=2, ls=style, label=arm)
        axis.set(xlabel="time [s]", ylabel=label)
        axis.legend(frameon=False, fontsize=8, loc="upper left")
        axis.spines[["top", "right"]].set_visible(False)
        if name == "near":
            axis.set(yscale="log")
            axis.set_yticks([3, 10, 30], ["3", "10", "30"])
            axis.minorticks_off()
    with mpl.rc_context({"svg.hashsalt": "ecs-eco", "svg.fonttype": "none"}):
        figure.savefig(path, metadata={"Date": None})
    return path


if __name__ == "__main__":
    draw_result(str(__doc__), "swarms", "swarms.svg", draw)
