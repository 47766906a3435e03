"""Draw docs/img/goats_carriers.png from studies/results/goats.json: the number of goats that carry each gene
over time.

Top: the run with the first seed, as in the paper's figure. Bottom: the share of carriers in each of an arm's
runs.
"""

import io
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
from PIL import Image

from ecs_eco.analysis.palette import CLEAR
from studies.common.figure import draw_result
from studies.common.goats import GENES, numbers

SHOWN = {"goats": "goats that learn", "frozen learning": "goats that do not learn"}
DASHES = {"red": "-", "yellow": "-", "green": "-", "blue": "--"}


def draw(record: dict[str, Any], path: Path) -> None:
    """Write a result's figure."""
    figure, axes = plt.subplots(3, 1, figsize=(8.5, 7), layout="constrained")
    first = next(e for e in record["cases"] if e["case"]["arm"] == "goats")
    one(axes[0], first["result"]["series"])
    axes[0].set_title(
        f"Goats that carry each gene, one run (seed {first['case']['seed']})", loc="left", fontsize=10
    )
    for ax, (arm, words) in zip(axes[1:], SHOWN.items(), strict=True):
        runs = [e["result"]["series"] for e in record["cases"] if e["case"]["arm"] == arm]
        for series in runs:
            share(ax, series)
        ax.set_title(f"Share of carriers, all {len(runs)} runs: {words}", loc="left", fontsize=10)
        ax.set_xlabel("generation")
    whole = io.BytesIO()
    figure.savefig(whole, dpi=90)
    Image.open(whole).convert("RGB").quantize(64).save(path, optimize=True)  # one third of the size


def one(ax: Any, series: dict[str, str]) -> None:
    """Plot the numbers of carriers over ticks."""
    for gene in GENES:
        ax.plot(
            numbers(series["tick"]),
            numbers(series[gene]),
            color=CLEAR[gene][0],
            ls=DASHES[gene],
            lw=1.5,
            label=gene,
        )
    ax.plot(numbers(series["tick"]), numbers(series["n"]), color="#888888", lw=0.8, label="all goats")
    ax.set_xlabel("tick")
    there = numbers(series["green"]) > 0
    ax.plot(
        numbers(series["tick"])[there],
        0 * numbers(series["n"])[there] - 25,
        "|",
        ms=5,
        color=CLEAR["green"][0],
        label="some green",
    )
    ax.set_ylim(-50)
    ax.legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))


def share(ax: Any, series: dict[str, str]) -> None:
    """Plot carrier shares over generations as thin lines."""
    n = numbers(series["n"])
    for gene in GENES:
        ax.plot(
            numbers(series["generation"])[n > 0],
            (numbers(series[gene])[n > 0] / n[n > 0]),
            color=CLEAR[gene][0],
            ls=DASHES[gene],
            lw=0.8,
        )
    ax.set_ylim(0, 1.02)


if __name__ == "__main__":
    draw_result(str(__doc__), "goats", "goats_carriers.png", draw)
