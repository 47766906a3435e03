"""Figures of a search: its progress, the important parameters, where good worlds are, and the posterior."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from ecs_eco.analysis.palette import AXIS, GREY, GRID, INK, SAFE
from ecs_eco.analysis.style import PALETTE, Figure, panels, several, styled
from ecs_eco.lab.response import short
from ecs_eco.lab.searching.optimise import merit
from ecs_eco.lab.searching.plan import Parameter
from ecs_eco.lab.searching.sampler import ENDS, Population, value_at, weighted_quantiles

STAGES = (GREY, PALETTE[5], PALETTE[2], INK)
BEST, START, POSTERIOR = PALETTE[3], INK, SAFE[6][0]
MOST = 6  # maximum number of parameters in the figure of pairs of the posterior


@styled
def history(entries: Sequence[dict[str, Any]], last: int) -> Figure:
    """Plot how far each candidate got, and the best candidate so far; `last` is the index of the last stage."""
    figure, ((ax,),) = panels(1, 1, 9, 3.4)
    minutes = np.array([e["at"] / 60 for e in entries])
    merits = np.array([merit(e) for e in entries])
    for stage in range(last + 1):
        here = [e["stage"] == stage for e in entries]
        tone = STAGES[round(stage / max(last, 1) * (len(STAGES) - 1))]
        word = "reached the last stage" if stage == last else f"stopped at stage {stage + 1}"
        ax.plot(minutes[here], merits[here], "o", ms=5, color=tone, label=f"{word} ({sum(here)})")
        ax.axhline(stage + 1, color=GRID, lw=1, zorder=0)
    order = minutes.argsort()
    ax.step(
        minutes[order],
        np.maximum.accumulate(merits[order]),
        where="post",
        color=BEST,
        lw=1.6,
        label="best so far",
    )
    for e in entries:
        if e["candidate"] == 0:
            ax.plot(e["at"] / 60, merit(e), "X", ms=9, color=START, label="as written")
    ax.set(
        xlabel="minutes",
        ylabel="stage reached, plus score in it",
        ylim=(0, last + 1.05),
        yticks=range(last + 2),
    )
    figure.legend(loc="outside upper left", ncols=4)
    return figure


@styled
def importance(numbers: Mapping[str, Mapping[str, float]]) -> Figure:
    """Plot each parameter's share of total importance, and the share exceeded by chance in 1 of 20 cases."""
    order = dict(sorted(numbers.items(), key=lambda one: one[1]["share"]))
    figure, ((ax,),) = panels(1, 1, 8, 0.34 * len(order) + 1.3)
    places = np.arange(len(order))
    ax.barh(places, [of["share"] for of in order.values()], height=0.6, color=PALETTE[2])
    limits = np.minimum([of["by_chance"] for of in order.values()], 1.0)
    ax.vlines(limits, places - 0.4, places + 0.4, color=BEST, lw=2, label="by chance, 19 of 20 cases")
    ax.set(
        yticks=places, yticklabels=[*map(short, order)], xlim=(0, 1.02), xlabel="share of total importance"
    )
    ax.legend(loc="lower right")
    return figure


@styled
def scatter(
    parameters: Sequence[Parameter],
    entries: Sequence[dict[str, Any]],
    worse: np.ndarray,
    start: dict[str, float],
    best: dict[str, float],
) -> Figure:
    """Plot the share of candidates that are worse, `worse` f64[candidates], against each parameter."""
    figure, axes = several(len(parameters), 4, (2.9, 2.3), (0.5, 0.4), sharey=True)
    for ax, p in zip(axes.flat, parameters, strict=False):
        ax.scatter(
            [e["values"][p.name] for e in entries],
            worse,
            s=18,
            color=PALETTE[2],
            alpha=0.6,
            lw=0,
            clip_on=False,
        )
        ax.axvline(start[p.name], color=START, lw=1.1, ls=":", label="as written")
        ax.axvline(best[p.name], color=BEST, lw=1.4, label="best")
        ax.set_ylim(0, 1)
        scaled(ax.xaxis, p, fontsize=9)
    for row in axes:
        row[0].set_ylabel("share of worse candidates")
    axes[0, 0].legend(loc="best", fontsize=9)
    return figure


@styled
def pairs(
    parameters: Sequence[Parameter],
    entries: Sequence[dict[str, Any]],
    worse: np.ndarray,
    order: Sequence[int],
    best: dict[str, float],
    start: dict[str, float],
) -> Figure:
    """Plot the candidates against pairs of three parameters, colored by the share of worse candidates."""
    chosen = list(combinations(order[:3], 2))
    figure, axes = panels(1, len(chosen), 3.9 * len(chosen) + 0.9, 3.6)
    for ax, pair in zip(axes[0], chosen, strict=True):
        x, y = (parameters[k] for k in pair)
        at = [[e["values"][p.name] for e in entries] for p in (x, y)]
        dots = ax.scatter(*at, c=worse, cmap="viridis", vmin=0, vmax=1, s=26, edgecolors=AXIS, linewidths=0.5)
        for values, mark, hue, label in ((start, "X", START, "as written"), (best, "*", BEST, "best")):
            ax.plot(
                values[x.name],
                values[y.name],
                mark,
                ms=12,
                color=hue,
                mec="white",
                label=label,
                clip_on=False,
                ls="none",
            )
        scaled(ax.xaxis, x)
        scaled(ax.yaxis, y)
        ax.grid(visible=False)
    axes[0, 0].legend(loc="best", fontsize=9, frameon=True)
    figure.colorbar(dots, ax=axes[0].tolist(), label="share of worse candidates", pad=0.02)
    return figure


@styled
def marginals(parameters: tuple[Parameter, ...], kept: Population, start: dict[str, float]) -> Figure:
    """Plot the posterior density of each parameter over its range."""
    figure, axes = several(len(parameters), 4, (2.9, 2.3), (0.4, 0.3))
    at = np.linspace(0, 1, 201)
    for k, (ax, p) in enumerate(zip(axes.flat, parameters, strict=False)):
        x = [value_at(p, u) for u in at]
        ax.fill_between(x, density(kept.at[:, k], kept.shares, at), color=POSTERIOR, alpha=0.35, lw=0)
        ax.axhline(1, color=GREY, lw=1)
        low, middle, high = weighted_quantiles(kept.at[:, k], kept.shares, ENDS)
        ax.plot([value_at(p, low), value_at(p, high)], [0, 0], color=POSTERIOR, lw=4, clip_on=False)
        ax.axvline(value_at(p, middle), color=POSTERIOR, lw=1.4, label="median")
        ax.axvline(start[p.name], color=START, lw=1.2, ls=":", label="as written")
        ax.set(ylim=(0, None), yticks=[])
        scaled(ax.xaxis, p, fontsize=9)
        ax.set_xlim(p.low, p.high)
    axes[0, 0].legend(loc="best", fontsize=9)
    return figure


@styled
def posterior_pairs(parameters: tuple[Parameter, ...], kept: Population) -> Figure:
    """Plot the posterior over pairs of the first parameters."""
    chosen = list(combinations(range(min(MOST, len(parameters))), 2))
    figure, axes = several(len(chosen), 3, (3.3, 2.9), (0.3, 0.2))
    for ax, (i, j) in zip(axes.flat, chosen, strict=False):
        x, y = ([value_at(parameters[k], u) for u in kept.at[:, k]] for k in (i, j))
        ax.scatter(x, y, s=20 + 400 * kept.shares, color=POSTERIOR, alpha=0.5, lw=0, clip_on=False)
        scaled(ax.xaxis, parameters[i], fontsize=9)
        scaled(ax.yaxis, parameters[j], fontsize=9)
        ax.set(xlim=(parameters[i].low, parameters[i].high), ylim=(parameters[j].low, parameters[j].high))
    return figure


def scaled(axis: Any, p: Parameter, **label: float) -> None:
    """Label an axis with a parameter; log axes have ticks at 1, 2 and 5 × 10ⁿ or, beyond two decades, at 10ⁿ."""
    getattr(axis.axes, f"set_{axis.axis_name}label")(short(p.name), **label)
    if not p.log:
        return
    getattr(axis.axes, f"set_{axis.axis_name}scale")("log")
    powers = np.arange(np.floor(np.log10(p.low)), np.ceil(np.log10(p.high)) + 1)
    steps = (1, 2, 5) if p.high / p.low <= 100 else (1,)
    ticks = [
        s * 10.0**k
        for k in powers
        for s in steps
        if p.low <= s * 10.0**k * 1.0001 and s * 10.0**k <= p.high * 1.0001
    ]
    axis.set_ticks(ticks, labels=[f"{t:g}" for t in ticks])
    axis.set_ticks([], minor=True)


def density(places: np.ndarray, shares: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return the normal-kernel density of weighted positions (Silverman's width), mirrored at 0 and 1."""
    mean = shares @ places
    wide = max(0.02, np.sqrt(shares @ (places - mean) ** 2) * (1.06 * (shares**2).sum() ** 0.2))
    mirrored = np.concatenate([places, -places, 2 - places])
    kernel = np.exp(-0.5 * ((at[:, None] - mirrored) / wide) ** 2)
    return np.asarray(kernel @ np.tile(shares, 3) / (wide * np.sqrt(2 * np.pi)))
