"""Figures of a crossed design: survival by training seed, and when each cell lost its first species."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.analysis.extinction import declines, lifetime
from ecs_eco.analysis.palette import AXIS, ON_CELL
from ecs_eco.analysis.seed_grid import Grid, survival_band
from ecs_eco.analysis.style import PALETTE, panels, styled
from ecs_eco.analysis.survival import kaplan_meier

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@styled
def persistence(grid: Grid, title: str = "") -> Figure:
    """Share of runs in which all species live (Kaplan–Meier): all runs thick, with a band;
    each training seed thin."""
    figure, ((ax,),) = panels(1, 1, 7, 3.4)
    lived, died = (
        grid.table(lambda run: lifetime(run)[0]),
        grid.table(lambda run: lifetime(run)[1]).astype(bool),
    )
    until = grid.length
    time, low, high = survival_band(grid)
    time, low, high = np.append(time, until), np.append(low, low[-1]), np.append(high, high[-1])
    ax.fill_between(time, low, high, step="post", color=PALETTE[2], alpha=0.15, lw=0)
    for k, (t, d) in enumerate(zip(lived, died, strict=True)):
        curve = kaplan_meier(t, d)
        shift = 0.006 * (k - (len(lived) - 1) / 2)  # seeds that agree stay apart
        ax.step(
            np.append(curve.time, until),
            np.append(curve.survival, curve.survival[-1]) + shift,
            where="post",
            color=AXIS,
            lw=0.8,
            label="one training seed" if k == 0 else None,
        )
    curve = kaplan_meier(lived.ravel(), died.ravel())
    ax.step(
        np.append(curve.time, until),
        np.append(curve.survival, curve.survival[-1]),
        where="post",
        color=PALETTE[2],
        lw=2.4,
        label=f"all {lived.size} runs",
    )
    ax.set(xlim=(0, until), ylim=(-0.04, 1.06), xlabel="tick", ylabel="share with all species", title=title)
    ax.legend(loc="lower left" if curve.survival[-1] > 0.4 else "upper right")
    return figure


@styled
def lifetimes(grid: Grid, title: str = "") -> Figure:
    """Time to the first extinction by training seed (rows) and world seed (columns);
    cells without extinction are marked."""
    rows, columns = len(grid.training), len(grid.worlds)
    figure, ((ax,),) = panels(1, 1, 2.4 + 1.05 * columns, 1.5 + 0.52 * rows)
    lived = grid.table(lambda run: lifetime(run)[0])
    top = max(grid.length, 1.0)
    image = ax.imshow(lived, cmap="cividis", vmin=0, vmax=top, aspect="auto")
    for i in range(rows):
        for j in range(columns):
            first = declines(grid.runs[i][j])[:1]
            text = f"{first[0].tick:,}\n{first[0].species}" if first else "all live"
            ax.text(
                j,
                i,
                text,
                ha="center",
                va="center",
                fontsize=8.5,
                color=ON_CELL[bool(lived[i, j] > 0.55 * top)],
            )
    for edge in range(1, rows):
        ax.axhline(edge - 0.5, color="white", lw=1.2)
    for edge in range(1, columns):
        ax.axvline(edge - 0.5, color="white", lw=1.2)
    ax.set(xlabel="world seed", ylabel="training seed", title=title)
    ax.set_xticks(range(columns), [str(s) for s in grid.worlds])
    ax.set_yticks(range(rows), [str(s) for s in grid.training])
    ax.grid(visible=False)
    figure.colorbar(image, ax=ax, label="tick of the first extinction", pad=0.02, format="{x:,.0f}")
    return figure
