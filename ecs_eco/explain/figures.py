"""Figures of sweeps: frequencies and what drift allows, clades, effects, and the path from gene to fate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ecs_eco.analysis.palette import BAND, GREY, INK, SOFT
from ecs_eco.analysis.style import PALETTE, Figure, empty, panels, several, styled
from ecs_eco.explain.account import Account
from ecs_eco.explain.alleles import Paths
from ecs_eco.explain.events import Sweep
from ecs_eco.explain.taken_out import TakenOut, clear

SHOWN = ("births", "survival", "energy", "died", "meals", "action")  # measures of the forest plot, in order
MOST = 12  # rows of a forest plot


@styled
def frequency(sweep: Sweep, paths: Paths) -> Figure:
    """Plot the frequency of a sweep's alleles, with a band that contains 95% of neutral alleles at each tick.

    Notes
    -----
    The band starts where the rise begins: p ± 1.96 √(p (1 − p) (1 − Π(1 − 1/Nₑ))), with 1/Nₑ in each step from
    unequal contributions, by the variance of the lead's share among organisms when its rise begins, and the
    random segregation of two parents' alleles (Crow and Kimura 1970, chapter 7, as a normal approximation). It
    does not contain mutation.
    """
    figure, ((ax,),) = panels(1, 1, 9, 3.2)
    names = [allele.name for allele in paths.alleles]
    low, high = neutral(sweep, paths)
    ax.fill_between(sweep.ticks, low, high, color=BAND, lw=0, label="drift only (95%)")
    for k, (allele, _) in enumerate(sweep.linked[:3]):
        if allele.name in names:
            path = paths.p[:, names.index(allele.name)]
            ax.plot(sweep.ticks, path, color=PALETTE[(k + 3) % len(PALETTE)], lw=1.0, label=allele.name)
    ax.plot(sweep.ticks, sweep.path, color=INK, lw=1.9, label=sweep.lead.name)
    for tick in (sweep.begin, sweep.half, sweep.end):
        ax.axvline(tick, color=SOFT, lw=0.8, ls=(0, (2, 2)))
    ax.set(
        xlabel="tick", ylabel="frequency", ylim=(-0.02, 1.02), xlim=(sweep.ticks[0], max(sweep.ticks[-1], 1))
    )
    figure.legend(loc="outside upper left", ncols=3)
    return figure


def neutral(sweep: Sweep, paths: Paths) -> tuple[np.ndarray, np.ndarray]:
    """Return the limits of the band of drift at each sample, f64[samples] each; NaN before the rise."""
    low, high = np.full((2, len(sweep.ticks)), np.nan)
    begin = int(np.searchsorted(sweep.ticks, sweep.begin))
    ploidy = max(1, round(float(np.nanmax(paths.n / np.maximum(paths.steps.living, 1)))))
    of, pairs = paths.steps.both, paths.steps.pairs
    if sweep.lead.kind == "clade":  # each organism has one, from its first parent
        of, pairs = paths.steps.maternal, 0 * pairs
    p = float(sweep.path[begin])
    # of p (1 − p), which is 1 / ploidy if the copies in an organism are independent, and 1 if all are the same
    between = paths.variance[begin, paths.alleles.index(sweep.lead)] / max(p * (1 - p), 1e-9)
    gained = np.maximum(of.square, 0) * between + pairs / (2 * ploidy)
    share = gained / np.maximum(of.value, 1e-9) ** 2  # 0 if no organism is alive
    lost = 1 - np.concatenate([[1.0], np.cumprod(1 - np.clip(share[begin:], 0, 1))])
    width = 1.96 * np.sqrt(p * (1 - p) * lost)
    low[begin:], high[begin:] = np.clip(p - width, 0, 1), np.clip(p + width, 0, 1)
    return low, high


@styled
def clades(paths: Paths, sweeps: Sequence[Sweep] = ()) -> Figure:
    """Draw a Muller plot: the clades of founders that reach 5%, as fractions of living organisms."""
    figure, ((ax,),) = panels(1, 1, 9, 3.2)
    own = [j for j, allele in enumerate(paths.alleles) if allele.kind == "clade"]
    own.sort(key=lambda j: np.nansum(paths.p[:, j]))
    shares = np.nan_to_num(paths.p[:, own].T)
    rest = np.clip(1 - shares.sum(axis=0, keepdims=True), 0, 1)
    hues = [GREY, *(PALETTE[k % len(PALETTE)] for k in range(len(own)))]
    names = ["all others", *(paths.alleles[j].name for j in own)]
    ax.stackplot(
        paths.ticks,
        np.concatenate([rest, shares]),
        colors=hues,
        alpha=0.75,
        labels=names,
        lw=0.4,
        edgecolor="white",
    )
    for sweep in sweeps:
        ax.axvline(sweep.half, color=INK, lw=0.9, ls=(0, (2, 2)))
    ax.set(
        xlabel="tick",
        ylabel="fraction of the living",
        ylim=(0, 1),
        xlim=(paths.ticks[0], max(paths.ticks[-1], 1)),
    )
    if len(own) < 12:
        figure.legend(loc="outside upper left", ncols=4)
    return figure


@styled
def effects(account: Account) -> Figure:
    """Draw the effects of taking alleles out, relative to the carriers that kept them, with 95% intervals."""
    several_ticks = len(account.at_first_tick) < len(account.taken)
    figure, axes = several(len(account.taken), 2, (5.0, 2.9), (0.4, 0.4))
    figure.set_layout_engine("constrained", w_pad=0.2)  # browsers may draw labels wider than they are here
    for ax, (allele, taken) in zip(axes.flat, account.taken, strict=False):
        rows = clearest(taken)
        y = -np.arange(len(rows))
        for measure, at in zip(rows, y, strict=True):
            x, usual = taken.effect(measure), scale(taken, measure)
            value, low, high = (100 * part / usual for part in x)
            hue = INK if clear(x) else GREY
            ax.plot([low, high], [at, at], color=hue, lw=1.6)
            ax.plot(value, at, "o", color=hue, ms=5)
        ax.axvline(0, color=SOFT, lw=0.9)
        ax.set_yticks(y, [words(measure) for measure in rows])
        title = f"{allele.name}, tick {taken.tick:,}" if several_ticks else allele.name
        ax.set(xlabel="change [% or points]", title=title)
        ax.grid(visible=False, axis="y")
    return figure


def clearest(taken: TakenOut) -> list[str]:
    """Return the measures to show: births, survival and energy, then those with the most certain effects."""
    known = [m for m in taken.means if np.isfinite(taken.effect(m)).all() and np.ptp(taken.effect(m)) > 0]
    known = [m for m in known if scale(taken, m) > 0]
    head = [m for m in ("births", "survival", "energy") if m in known]

    def clarity(measure: str) -> float:
        x = taken.effect(measure)
        return abs(x.value) / (x.high - x.low)

    rest = sorted((m for m in known if m not in (*head, "alive")), key=clarity, reverse=True)
    return [*head, *rest[: MOST - len(head)]]


def scale(taken: TakenOut, measure: str) -> float:
    """Return what counts as 100%: the mean of the unchanged organisms, which can be 0, or 1 for shares."""
    return 1.0 if measure.startswith(("died", "action")) else abs(taken.control(measure).value)


def words(measure: str) -> str:
    """Return a measure in words."""
    kind, _, name = measure.partition(": ")
    plain = {"births": "young", "survival": "time lived", "energy": "energy taken in"}
    long = {"died": f"death: {name}", "meals": f"{name} eaten", "action": f"action {name}"}
    return plain.get(kind) or long.get(kind, measure)


@styled
def way(account: Account, trait: str) -> Figure:
    """Draw the path from an allele to young: its trait, and the action and cause of death that change most."""
    allele, taken = account.taken[0]
    boxes = [
        allele.name,
        trait or "no trait",
        *(largest(taken, kind) for kind in ("action", "died")),
        birth(taken),
    ]
    boxes = [box for box in boxes if box]
    figure = empty(9, 1.3)
    ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    ax.set_axis_off()
    places = (np.arange(len(boxes)) + 0.5) / len(boxes)
    for k, (x, box) in enumerate(zip(places, boxes, strict=True)):
        text = box.replace(", ", ",\n").replace(": ", ":\n").replace(" (", "\n(")
        ax.text(
            x,
            0.5,
            text,
            ha="center",
            va="center",
            fontsize=9,
            color=INK,
            bbox={"boxstyle": "round,pad=0.5", "fc": "white", "ec": SOFT},
        )
        if k:
            ax.annotate(
                "",
                (x - 0.36 / len(boxes), 0.5),
                (places[k - 1] + 0.36 / len(boxes), 0.5),
                arrowprops={"arrowstyle": "->", "color": SOFT},
            )
    ax.set(xlim=(0, 1), ylim=(0, 1))
    return figure


def largest(taken: TakenOut, kind: str) -> str:
    """Return the largest effect on one kind of measure in words; "" if all intervals contain 0."""
    own = {m: x for m in taken.means if m.startswith(kind) and clear(x := taken.effect(m))}
    if not own:
        return ""
    measure = max(own, key=lambda m: abs(own[m].value))
    return f"{words(measure)}, {100 * own[measure].value:+.0f} points without it".replace("-", "−")


def birth(taken: TakenOut) -> str:
    """Return the effect on the number of young in words."""
    x = taken.effect("births")
    if not clear(x):
        return "young: no clear change"
    usual = scale(taken, "births")
    change = f"{100 * x.value / usual:+.0f}%" if usual else f"{x.value:+.2g} each"
    return f"young, {change} without it".replace("-", "−")
