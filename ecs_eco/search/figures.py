"""Figures of a search: how it went, what mattered, and where the good worlds lie."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.analysis.figures import _grid, _styled
from ecs_eco.search.matters import Matter, Process, dependence, unit, value_of
from ecs_eco.search.optimise import merit
from ecs_eco.search.plan import Parameter

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STAGES = ("#b8c0c8", "#56B4E9", "#0072B2", "#08306b")
BEST, START = "#D55E00", "#000000"


@_styled
def history(entries: Sequence[dict[str, Any]], last: int) -> Figure:
    """How far each candidate came, and the best so far; `last` is the number of the last stage."""
    figure, ((ax,),) = _grid(1, 1, 9, 3.4)
    minutes = np.array([e["at"] / 60 for e in entries])
    found = np.array([merit(e) for e in entries])
    for stage in range(last + 1):
        here = [e["stage"] == stage for e in entries]
        word = "all runs" if stage == last else f"stopped at stage {stage + 1}"
        ax.plot(minutes[here], found[here], "o", ms=5, color=_tone(stage, last), label=f"{word} ({sum(here)})")
        ax.axhline(stage + 1, color="#e6eaee", lw=1, zorder=0)
    order = minutes.argsort()
    ax.step(minutes[order], np.maximum.accumulate(found[order]), where="post", color=BEST, lw=1.6, label="best so far")
    begin = next((i for i, e in enumerate(entries) if e["candidate"] == 0), None)
    if begin is not None:
        ax.plot(minutes[begin], found[begin], "X", ms=9, color=START, label="as written")
    ax.set(xlabel="minutes", ylabel="stage reached, and score in it", ylim=(0, last + 1.05), yticks=range(last + 2))
    figure.legend(loc="outside upper center", ncols=4)
    return figure


def _tone(stage: int, last: int) -> str:
    return STAGES[round(stage / max(last, 1) * (len(STAGES) - 1))]


@_styled
def importance(found: Sequence[Matter]) -> Figure:
    """Share of the variance that each number explains, alone and with the others; bars are medians, lines 90 % intervals."""
    order = sorted(found, key=lambda m: m.total[0])
    figure, ((ax,),) = _grid(1, 1, 8, 0.42 * len(order) + 1.3)
    for k, m in enumerate(order):
        for shift, (middle, low, high), hue in ((0.18, m.total, "#0072B2"), (-0.18, m.first, "#56B4E9")):
            ax.barh(k + shift, middle, height=0.34, color=hue)
            ax.plot([low, high], [k + shift] * 2, color="#1b1f23", lw=1.2)
    ax.barh([0], [0], color="#0072B2", label="with the others")
    ax.barh([0], [0], color="#56B4E9", label="alone")
    ax.set(yticks=range(len(order)), yticklabels=[short(m.name) for m in order], xlim=(0, 1), xlabel="share of variance explained")
    ax.legend(loc="lower right")
    return figure


def short(name: str) -> str:
    """A key without the word species."""
    return name.removeprefix("species.")


@_styled
def curves(fit: Process, parameters: Sequence[Parameter], start: dict[str, float], best: dict[str, float]) -> Figure:
    """What each number does, averaged over all others: the share of candidates that are worse, with one standard deviation."""
    columns = min(4, len(parameters))
    rows = -(-len(parameters) // columns)
    figure, axes = _grid(rows, columns, 2.9 * columns + 0.5, 2.3 * rows + 0.4, sharey=True)
    for ax, (i, p) in zip(axes.flat, enumerate(parameters), strict=False):
        grid, mean, sd = dependence(fit, i)
        at = value_of(p, grid)
        ax.fill_between(at, mean - sd, mean + sd, color="#0072B2", alpha=0.18, lw=0)
        ax.plot(at, mean, color="#0072B2", lw=1.8)
        ax.axvline(start[p.name], color=START, lw=1.1, ls=":", label="as written")
        ax.axvline(best[p.name], color=BEST, lw=1.4, label="best")
        ax.set(xlabel=short(p.name), ylim=(0, 1), xscale="log" if p.log else "linear")
    for ax in list(axes.flat)[len(parameters) :]:
        ax.set_visible(False)
    for row in axes:
        row[0].set_ylabel("share that is worse")
    axes[0, 0].legend(loc="best", fontsize=8)
    return figure


@_styled
def pairs(fit: Process, parameters: Sequence[Parameter], entries: Sequence[dict[str, Any]], worth: np.ndarray, order: Sequence[int],
          best: dict[str, float], start: dict[str, float]) -> Figure:  # fmt: skip
    """Maps of pairs of the numbers that matter most: the process where all others are as in the best world, and the candidates."""
    chosen = list(combinations(order[:3], 2)) or [(0, 0)]
    figure, axes = _grid(1, len(chosen), 3.9 * len(chosen) + 0.9, 3.6)
    x, at_best, at_start = (unit(parameters, v) for v in ([e["values"] for e in entries], [best], [start]))
    share = np.linspace(0, 1, 41)
    for ax, (i, j) in zip(axes[0], chosen, strict=True):
        points = np.repeat(at_best, 41 * 41, 0)
        points[:, i], points[:, j] = (g.ravel() for g in np.meshgrid(share, share))
        a, b = (value_of(parameters[k], share) for k in (i, j))
        height = fit.foretell(points).reshape(41, 41)
        shade = ax.contourf(a, b, height, levels=np.linspace(0, 1, 11), cmap="viridis", extend="both", alpha=0.75)
        xy = [value_of(parameters[k], x[:, k]) for k in (i, j)]
        ax.scatter(*xy, c=worth, cmap="viridis", vmin=0, vmax=1, s=18, edgecolors="white", linewidths=0.5)
        for place, mark, hue, word in ((at_start, "X", START, "as written"), (at_best, "*", BEST, "best")):
            at = [value_of(parameters[k], place[:, k]) for k in (i, j)]
            ax.plot(*at, mark, ms=12, color=hue, mec="white", label=word, clip_on=False, ls="none")
        ax.set(xlabel=short(parameters[i].name), ylabel=short(parameters[j].name))
        ax.set(xscale=_scale(parameters[i]), yscale=_scale(parameters[j]))
        ax.grid(visible=False)
    axes[0, 0].legend(loc="best", fontsize=8, frameon=True)
    figure.colorbar(shade, ax=axes[0].tolist(), label="share that is worse", pad=0.02)
    return figure


def _scale(p: Parameter) -> str:
    return "log" if p.log else "linear"
