"""A figure that explains a run: population sizes, causes of death, energy per capita."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ecs_eco.analysis import palette
from ecs_eco.analysis.figures import FLOWS, binned, interventions, mark
from ecs_eco.analysis.palette import SOFT
from ecs_eco.analysis.runs import DIED
from ecs_eco.analysis.style import DASHES, HATCHES, Axes, Figure, colors_of, fills, panels, styled
from ecs_eco.analysis.why.case import Case
from ecs_eco.analysis.why.diagnose import VERDICTS

OUT = tuple((name, word, palette.FLOWS[name]) for name, word, sign in FLOWS if sign < 0)
IN = palette.FLOWS["taken_in"]
MOST = 5  # maximum number of species with a row


@styled
def draw(case: Case, findings: Mapping[str, Any]) -> Figure:
    """Plot population sizes (top) and, for each animal (rows), causes of death (left) and energy (right)."""
    shown = _shown(case, findings)
    figure, _ = panels(1, 1, 11, 3.1 + 1.75 * len(shown))
    figure.clear()
    rows = figure.add_gridspec(len(shown) + 1, 2, height_ratios=[1.7, *[1.0] * len(shown)])
    top = figure.add_subplot(rows[0, :])
    _numbers(top, case, findings)
    looks = fills(case.series)
    used = {c: looks[c] for c in looks if any(case.series.of(s, DIED + c).any() for s in shown)}
    for i, s in enumerate(shown):
        left, right = (figure.add_subplot(rows[i + 1, side], sharex=top) for side in (0, 1))
        _causes(left, case, s, used)
        _energy(right, case, s)
        if i == 0:
            left.set_title(f"causes of death: {s}")
            right.set_title(f"energy per capita per tick: {s}")
        if i == len(shown) - 1:
            left.set_xlabel("tick")
            right.set_xlabel("tick")
    top.set_xlim(*_span(case))
    if shown:
        _legend(figure, used)
    return figure


def _span(case: Case) -> tuple[float, float]:
    """Return the first and last tick to show; if all animals die out early, most later ticks are left out."""
    ticks = case.series.ticks
    animals = [i for i, s in enumerate(case.species) if case.is_animal(s) and case.series.present[i]]
    gone = case.series.extinct[animals]
    last = float(ticks[-1])
    if len(animals) and not np.isnan(gone).any():
        last = min(last, float(ticks[0] + 1.5 * (gone.max() - ticks[0]) + 10))
    return float(ticks[0]), max(last, float(ticks[0]) + 1)


def _shown(case: Case, findings: Mapping[str, Any]) -> list[str]:
    """Return the species to show: animals that declined, other animals with deaths, declining plants."""
    fell = [f["species"] for f in findings["fell"]]
    died = [s for s in case.species if case.flow(s, "deaths").any()]
    animals = [s for s in died if case.is_animal(s)]
    order = [*(s for s in animals if s in fell), *animals, *(s for s in died if s in fell)]
    return list(dict.fromkeys(order))[:MOST]


def _numbers(ax: Axes, case: Case, findings: Mapping[str, Any]) -> None:
    from matplotlib.ticker import LogFormatter

    series, hue = case.series, colors_of(case.series)
    for i, s in enumerate(series.species):
        n = series.n[:, i]
        alive = np.where(n > 0, n, np.nan)
        ax.plot(series.ticks, alive, color=hue[s], label=s, ls=DASHES[i % len(DASHES)], lw=1.7)
        if not np.isnan(series.extinct[i]) and n.any():
            last = int(np.flatnonzero(n)[-1])
            ax.plot(series.extinct[i], n[last], "x", color=hue[s], ms=10, mew=2.6, zorder=5, clip_on=False)
            ax.axvline(series.extinct[i], color=hue[s], lw=0.9, ls=":", zorder=1)
    ax.set_yscale("log")
    ax.set(ylabel="number", ylim=(0.8, None), xlabel="")
    ax.yaxis.set_major_formatter("{x:,.0f}")
    ax.yaxis.set_minor_formatter(LogFormatter())  # plain numbers, because math text is not parsed
    verdict = VERDICTS["healthy"] if findings["verdict"] == "healthy" else findings["verdict"]
    ax.set_title(f"{verdict} ({findings['species']})" if findings["species"] else verdict)
    ax.legend(loc="center left", bbox_to_anchor=(1.005, 0.5))
    mark(ax, interventions(series))


def _causes(ax: Axes, case: Case, species: str, used: Mapping[str, tuple[str, str]]) -> None:
    counts = np.stack([case.series.of(species, DIED + c) for c in used], -1)
    middle, rate = binned(case.series, counts, 60)
    total = rate.sum(1, keepdims=True)
    share = np.divide(rate, total, out=np.zeros_like(rate), where=total > 0)
    width = np.diff(middle, append=2 * middle[-1] - middle[-2] if len(middle) > 1 else middle[-1] + 1)
    base = np.zeros(len(middle))
    for k, (hue, pattern) in enumerate(used.values()):
        ax.bar(middle, share[:, k], width, bottom=base, lw=0, facecolor=hue, hatch=pattern, edgecolor="white")
        base += share[:, k]
    ax.set(ylim=(0, 1), ylabel="share of deaths", title=species)
    ax.yaxis.set_major_formatter(lambda x, _: f"{x:.0%}")


def _energy(ax: Axes, case: Case, species: str) -> None:
    n = case.series.of(species)
    middle, heads = binned(case.series, n[:, None], 60)
    flows = np.stack([case.flow(species, name) for name in ("taken_in", *(name for name, _, _ in OUT))], -1)
    _, per = binned(case.series, flows, 60)
    per = np.divide(per, heads, out=np.full_like(per, np.nan), where=heads >= 0.5)
    ax.plot(middle, per[:, 0], color=IN, lw=1.8)
    ax.fill_between(middle, 0, per[:, 0], color=IN, alpha=0.25, lw=0)
    base = np.zeros(len(middle))
    for k, (_, _, colour) in enumerate(OUT):
        end = base - per[:, k + 1]
        ax.fill_between(
            middle, base, end, lw=0, alpha=0.85, color=colour, hatch=HATCHES[k], edgecolor="white"
        )
        base = end
    ax.axhline(0, color=SOFT, lw=0.8)
    span = np.nanquantile(np.abs(np.concatenate([per[:, 0], base])), 0.98) if np.isfinite(base).any() else 1.0
    ax.set(title=species, ylim=(-1.15 * span, 1.15 * span) if span > 0 else None)


def _legend(figure: Figure, used: Mapping[str, tuple[str, str]]) -> None:
    from matplotlib.patches import Patch

    intake = Patch(facecolor=IN, alpha=0.5, label="taken in")
    out = {word: (hue, HATCHES[k]) for k, (_, word, hue) in enumerate(OUT)}
    for first, looks, side, ncols, title in (
        ([], used, "left", 3, "causes of death"),
        ([intake], out, "right", 2, "energy"),
    ):
        patches = [
            Patch(fc=hue, hatch=pattern, ec="white", label=word) for word, (hue, pattern) in looks.items()
        ]
        where: Any = {"loc": f"outside lower {side}", "alignment": "left"}
        figure.legend(handles=[*first, *patches], ncols=ncols, title=title, fontsize=9, **where)
