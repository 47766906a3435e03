"""Figures of one or several runs, as matplotlib Figures without global state; `save` writes one."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ecs_eco.analysis import palette
from ecs_eco.analysis.cycles import Surrogates, cross_correlation, living_stretch
from ecs_eco.analysis.land import Land, draw_land
from ecs_eco.analysis.palette import AXIS, BAND, INK, SOFT, TIME
from ecs_eco.analysis.relief import Relief, draw_relief
from ecs_eco.analysis.runs import DIED, Series, load_series
from ecs_eco.analysis.spectrum import Peak, smooth, thin, transform
from ecs_eco.analysis.style import (
    DASHES,
    PALETTE,
    Axes,
    Figure,
    colors,
    colors_of,
    fills,
    grid_of_arms,
    many_and_one,
    over_ticks,
    panels,
    save as save,
    save_svg as save_svg,
    styled,
)
from ecs_eco.analysis.survival import SurvivalCurve
from ecs_eco.analysis.svg import DIM
from ecs_eco.config.models.interventions import describe
from ecs_eco.engine.errors import shortened, unknown_name


@styled
def populations(series: Series) -> Figure:
    """Plot population sizes over time; a species over four times as numerous as the next has its own axis.

    Parameters
    ----------
    series : Series

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> from ecs_eco.analysis import figures
    >>> from ecs_eco.analysis.runs import load_series
    >>> series = load_series({"hare": [10, 12, 9], "lynx": [3, 3, 0]})
    >>> figures.populations(series).axes[0].get_xlabel()
    'tick'
    """
    figure, ((ax,),) = panels(1, 1, 9, 3.6)
    hue, top = colors_of(series), series.n.max(0, initial=0)
    rest = np.sort(top)[:-1].max(initial=0)
    alone = int(top.argmax()) if len(top) > 1 and rest and top.max() > 4 * rest else -1
    right = ax.twinx() if alone >= 0 else None
    for i, s in enumerate(series.species):
        on = right if i == alone and right is not None else ax
        on.plot(series.ticks, series.n[:, i], color=hue[s], label=s)
        if not np.isnan(series.extinct[i]) and series.present[i]:
            on.plot(series.extinct[i], 0, "x", color=hue[s], ms=9, mew=2.2, clip_on=False, zorder=5)
    ax.set(xlabel="tick", ylabel="number", ylim=(0, None))
    if right is not None:
        name = series.species[alone]
        right.set(ylim=(0, None))
        right.set_ylabel(f"number of {name}", color=hue[name])
        right.tick_params(axis="y", colors=hue[name])
        right.grid(visible=False)
        right.spines["right"].set_visible(True)
        ax.set_ylabel("number of " + ", ".join(s for i, s in enumerate(series.species) if i != alone))
    figure.legend(loc="outside upper left", ncols=5)
    ax.margins(x=0)
    mark(figure.axes[-1], interventions(series))
    return figure


def interventions(series: Series) -> list[tuple[int, str]]:
    """Return the tick and text of each intervention carried out, in chronological order."""
    return [(int(tick), describe(done)) for tick, done in series.manifest.get("intervened") or ()]


ALONG: dict[str, Any] = {"rotation": 90, "ha": "left", "va": "top", "fontsize": 9, "color": INK}
PATCH = {"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.6}
"""Styles of the text along a vertical line, and of the patch behind it."""


def mark(ax: Axes, done: Sequence[tuple[int, str]]) -> None:
    """Draw a vertical line at each intervention; the first of each kind is labeled if there is space."""
    room = float(np.ptp(ax.get_xlim())) / 45  # width of a line of text
    last, labelled = -np.inf, set[str]()
    for tick in sorted({t for t, _ in done}):
        ax.axvline(tick, color=SOFT, lw=0.9, ls=(0, (3, 2)), zorder=1)
        fresh = dict.fromkeys(label for t, label in done if t == tick and label not in labelled)
        if fresh and tick - last >= room:
            where: Any = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points"}
            ax.annotate(shortened("; ".join(fresh), 44), (tick, 1), (2, -3), bbox=PATCH, **where, **ALONG)
            last = tick
            labelled.update(fresh)


def plot(world: Any, column: str = "n", species: Sequence[str] | None = None) -> Figure:
    """Plot a column of a world's series over time, with one line per species; notebooks display the figure. Raises
    RuntimeError if nothing is recorded, KeyError if the column or a species is unknown."""
    series = load_series(world.series(), species)
    colours = {name: table.species.color for name, table in world.tables.items() if table.species.color}
    series = replace(series, manifest={"colors": colours, "dt": world.dt, "intervened": world.intervened})
    if column not in series.columns:
        raise KeyError(unknown_name("the series", "column", column, [*series.columns]))
    return populations(series) if column == "n" else over_time(series, column)


@styled
def over_time(series: Series, column: str) -> Figure:
    """Plot a column over time, with one line for each species that has values.

    Parameters
    ----------
    series : Series
    column : str

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> from ecs_eco.analysis import figures
    >>> from ecs_eco.analysis.runs import load_series
    >>> series = load_series({"hare": [10, 12, 9], "lynx": [3, 3, 0]})
    >>> figures.over_time(series, "n").axes[0].get_ylabel()
    'n'
    """
    figure, ((ax,),) = panels(1, 1, 9, 3.6)
    hue = colors_of(series)
    for name in series.species:
        values = series.of(name, column)
        if np.any(np.nan_to_num(values)):
            ax.plot(series.ticks, values, color=hue[name], label=name)
    ax.set(xlabel="tick", ylabel=column)
    if ax.get_lines():
        figure.legend(loc="outside upper left", ncols=len(series.species))
    ax.margins(x=0)
    mark(ax, interventions(series))
    return figure


@styled
def phase(series: Series, pairs: Sequence[tuple[str, str]]) -> Figure:
    """Plot pairs of species over time (prey on x, consumer on y; color: time), smoothed over 1% of the run.

    Parameters
    ----------
    series : Series
    pairs : sequence of (str, str)
        Prey and consumer.

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> from ecs_eco.analysis import figures
    >>> from ecs_eco.analysis.runs import load_series
    >>> series = load_series({"hare": [10, 12, 9], "lynx": [3, 3, 0]})
    >>> figures.phase(series, [("hare", "lynx")]).axes[0].get_ylabel()
    'lynx'
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    figure, axes = panels(1, len(pairs), 4.4 * len(pairs) + 0.7, 3.9)
    for ax, (a, b) in zip(axes[0], pairs, strict=True):
        window = max(1, len(series.ticks) // 100)
        x, y = (thin(smooth(series.of(s), window), 1500)[0] for s in (a, b))
        ends = np.linspace(0, len(x) - 1, len(TIME) + 1).astype(int)
        for a_end, b_end, colour in zip(ends, ends[1:], TIME, strict=False):
            ax.plot(x[a_end : b_end + 1], y[a_end : b_end + 1], color=colour, lw=1.3)
        ax.plot(x[0], y[0], "o", color=TIME[0], ms=6, label="start")
        ax.plot(x[-1], y[-1], "s", color=TIME[-1], ms=6, label="end")
        ax.set(xlabel=a, ylabel=b, title=f"{a} and {b}")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper left", ncols=2)
    lines = ScalarMappable(Normalize(series.ticks[0], series.ticks[-1]), ListedColormap(TIME))
    figure.colorbar(lines, ax=axes[0].tolist(), label="tick", pad=0.02)
    return figure


@styled
def spectra(peaks: Mapping[str, Peak], hue: Mapping[str, str] | None = None) -> Figure:
    """Plot each species' spectrum, the fitted red noise, and the level that noise exceeds in 1 of 20 cases.

    Parameters
    ----------
    peaks : mapping of str to Peak
        By species, from `spectral_peak`.
    hue : mapping of str to str, optional
        Color of each species; default: the palette.

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis import figures
    >>> from ecs_eco.analysis.spectrum import spectral_peak
    >>> peak = spectral_peak(9 + np.sin(2 * np.pi * np.arange(1000) / 50), n_boot=99)
    >>> figures.spectra({"hare": peak}).axes[0].get_xlabel()
    'period [ticks]'
    """
    figure, axes = panels(1, len(peaks), 3.5 * len(peaks) + 0.6, 3.4)
    hue = hue or colors(list(peaks))
    for ax, (s, peak) in zip(axes[0], peaks.items(), strict=True):
        used = slice(1, len(peak.frequency) // 2)
        periods = 1 / peak.frequency[used]
        band = (peak.expected * peak.limit)[used]
        ax.fill_between(periods, 1e-12, band, color=BAND, lw=0, label="red noise, 95%")
        ax.loglog(periods, peak.expected[used], color=AXIS, lw=1.1, ls="--", label="red noise, fitted")
        ax.loglog(periods, peak.power[used], color=hue[s], label=s)
        named = "no recurring period"
        if peak.recurs:
            named = f"{peak.period:,.0f} ticks, p {'≤' if peak.p <= 0.002 else '='} {peak.p:.2g}"
            ax.axvline(peak.period, color=INK, lw=0.8, ls=":")
        low, high = max(peak.power[used].min(), 1e-6 * peak.power.max()), max(band.max(), peak.power.max())
        ax.set_ylim(low / 2, 3 * high)
        ax.minorticks_off()
        ax.xaxis.set_major_formatter("{x:,.0f}")
        ax.set_title(f"{s}: {named}")
        ax.set_xlabel("period [ticks]")
    axes[0, 0].set_ylabel("power")
    axes[0, 0].legend(loc="lower right", fontsize=9, frameon=True, framealpha=1, edgecolor="none")
    return figure


@styled
def lags(
    series: Series,
    pairs: Sequence[tuple[str, str]],
    period: float,
    surrogates: Mapping[str, Surrogates] | None = None,
) -> Figure:
    """Plot the cross-correlation of each pair within ± one period, with the band of cross-seed pairs, if any.

    Parameters
    ----------
    series : Series
    pairs : sequence of (str, str)
    period : float
        [ticks]
    surrogates : mapping of str to Surrogates, optional
        By pair, "a→b".

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis import figures
    >>> from ecs_eco.analysis.runs import load_series
    >>> t = 2 * np.pi * np.arange(400) / 50
    >>> series = load_series({"hare": 9 + np.sin(t), "lynx": 9 - np.cos(t)})
    >>> figures.lags(series, [("hare", "lynx")], period=50).axes[0].get_xlabel()
    'lynx behind hare [periods]'
    """
    figure, axes = panels(1, len(pairs), 3.6 * len(pairs) + 0.6, 3.2, sharey=True)
    for ax, (a, b) in zip(axes[0], pairs, strict=True):
        band = (surrogates or {}).get(f"{a}→{b}")
        if band is not None:
            label = f"{a} and {b} of different runs, 95%"
            ax.fill_between(band.lags, band.low, band.high, color=BAND, lw=0, label=label)
            ax.plot(band.lags, band.real.T, color=PALETTE[2], lw=0.8, alpha=0.5)
            x, y = band.lags, band.real.mean(0)
        else:
            chosen = Series(series.ticks, (a, b), {"n": np.stack([series.of(a), series.of(b)], 1)})
            numbers, factor = thin(transform(living_stretch(chosen).T), 2048)
            at, y = cross_correlation(numbers[0], numbers[1], round(period / factor))
            x = at * factor / period
        ax.plot(x, y, color=PALETTE[2], lw=2, label="same run")
        after = x >= 0
        best = x[after][y[after].argmax()]
        ax.axvline(0, color=AXIS, lw=0.8)
        ax.axvline(best, color=PALETTE[3], lw=1.2, ls="--", label=f"highest at {best:.2f}")
        ax.set(xlabel=f"{b} behind {a} [periods]", title=f"{a} → {b}", xlim=(-1, 1), ylim=(-1, 1.05))
        ax.legend(loc="lower left", fontsize=9)
    axes[0, 0].set_ylabel("correlation")
    return figure


def binned(series: Series, columns: np.ndarray, bins: int = 120) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean per tick of columns (ticks, …) in at most `bins` bins, and the centers of the bins."""
    edges = np.unique(np.linspace(0, len(series.ticks), min(bins, len(series.ticks)) + 1).astype(int))
    total = np.add.reduceat(columns, edges[:-1], axis=0)
    width = np.diff(edges).reshape(-1, *[1] * (columns.ndim - 1))
    return series.ticks[(edges[:-1] + edges[1:] - 1) // 2], total / width


@styled
def deaths(series: Series) -> Figure:
    """Plot deaths per tick by cause, stacked, with a panel for each species that had deaths.

    Parameters
    ----------
    series : Series

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.analysis import figures
    >>> from ecs_eco.analysis.runs import load_series
    >>> series = load_series(World.from_config("predator-prey", policies="random").run(3).series())
    >>> figures.deaths(series).axes[-1].get_xlabel()
    'tick'
    """
    counts = np.stack([series.columns[DIED + c] for c in series.causes], -1)  # (ticks, species, causes)
    shown = [i for i in range(len(series.species)) if counts[:, i].any()]
    used = [j for j in range(len(series.causes)) if counts[..., j].any()]
    causes, looks = [series.causes[j] for j in used], fills(series)
    figure, axes = over_ticks(max(1, len(shown)), 1.9, 0.7)
    for ax, i in zip(axes, shown, strict=False):
        middle, rate = binned(series, counts[:, i][:, used])
        ax.stackplot(middle, rate.T, colors=[looks[cause][0] for cause in causes], lw=0)
        for cause, area in zip(causes, ax.collections, strict=True):
            area.set(hatch=looks[cause][1], edgecolor="white", linewidth=0)
        ax.set(ylabel="deaths per tick", title=series.species[i], ylim=(0, None))
        ax.margins(x=0)
    if shown:
        figure.legend(axes[0].collections, causes, loc="outside upper left", ncols=5)
    return figure


FLOWS = (
    ("taken_in", "taken in", 1),
    ("endowed", "endowed", 1),
    ("burnt", "burned", -1),
    ("given", "given to newborns", -1),
    ("lost", "held at death", -1),
)


@styled
def energy(series: Series) -> Figure:
    """Plot each species' energy flows per tick: inflows above zero, outflows below, and the net flow.

    Parameters
    ----------
    series : Series

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.analysis import figures
    >>> from ecs_eco.analysis.runs import load_series
    >>> series = load_series(World.from_config("predator-prey", policies="random").run(3).series())
    >>> figures.energy(series).axes[-1].get_xlabel()
    'tick'
    """
    figure, axes = over_ticks(len(series.species), 2.1, 0.6)
    for ax, (i, s) in zip(axes, enumerate(series.species), strict=True):
        for sign in (1, -1):
            flows = [flow for flow in FLOWS if flow[2] == sign and flow[0] in series.columns]
            middle, rate = binned(series, np.stack([series.columns[flow[0]][:, i] for flow in flows], -1))
            labels, hues = [flow[1] for flow in flows], [palette.FLOWS[flow[0]] for flow in flows]
            ax.stackplot(middle, sign * rate.T, colors=hues, labels=labels, lw=0)
        ax.axhline(0, color=INK, lw=0.8)
        ax.set(title=s, ylabel="energy per tick")
        ax.margins(x=0)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper left", ncols=5)
    return figure


@styled
def positions(
    at: Mapping[str, np.ndarray],
    size: Sequence[float],
    hue: Mapping[str, str],
    title: str = "",
    land: Land | None = None,
    relief: Relief | None = None,
) -> Figure:
    """Draw a map of all organisms from their positions (n, 3) [m] by species, with later species on top: a volume
    from the side (x, z), a plane above its ground (`relief`) and roads, fences and areas (`land`)."""
    volume = len(size) > 2 and size[2] > 0
    high = size[2] if volume else size[1]
    figure, ((ax,),) = panels(1, 1, 6.6, 6.0 * float(np.clip(high / size[0], 0.3, 1.2)) + 0.7)
    for i, (s, xyz) in enumerate(at.items()):
        area = float(np.clip(9000 / max(len(xyz), 1), 3, 26)) * (0.6, 1.0, 1.4)[min(i, 2)]
        xy = xyz[:, [0, 2]] if volume else xyz[:, :2]
        style = {"color": hue[s], "marker": "os^Dv"[i % 5], "lw": 0.4, "edgecolor": "white"}
        ax.scatter(*_apart(xy, size[0]).T, s=area, label=f"{s} ({len(xyz):,})", zorder=2 + i, **style)
    ax.set(xlim=(0, size[0]), ylim=(0, high), aspect="equal", title=title)
    ax.set(xlabel="x [m]", ylabel="z [m]" if volume else "y [m]")
    if land is not None and not volume:
        draw_land(ax, land)
    if relief is not None and not volume:
        figure.set_gid(DIM)
        draw_relief(ax, relief, size)
    ax.grid(visible=False)
    for side in ("top", "right"):
        ax.spines[side].set_visible(True)
    shown = figure.legend(loc="outside upper left", ncols=5)
    for handle in shown.legend_handles:
        handle.set_sizes([28])  # type: ignore[union-attr]
    return figure


def _apart(xy: np.ndarray, wide: float) -> np.ndarray:
    """Return one position per square with a side of 1/300 of the width, because more dots would look the same."""
    if len(xy) < 5000:
        return xy
    column, row = np.floor(xy * (300 / wide)).astype(np.int64).T
    return xy[np.sort(np.unique(column << 32 | row, return_index=True)[1])]


@styled
def survival(
    curves: Mapping[str, SurvivalCurve], until: float, title: str = "", hue: Mapping[str, str] | None = None
) -> Figure:
    """Plot the Kaplan–Meier curve of each group with its 95% band.

    Parameters
    ----------
    curves : mapping of str to SurvivalCurve
        By group.
    until : float
        End of the time axis [ticks].
    title : str, default ""
    hue : mapping of str to str, optional
        Color of each group; default: the palette.

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> from ecs_eco.analysis import figures
    >>> from ecs_eco.analysis.survival import kaplan_meier
    >>> figures.survival({"hare": kaplan_meier([2.0, 3.0], [True, False])}, until=4).axes[0].get_ylabel()
    'fraction surviving'
    """
    figure, ((ax,),) = panels(1, 1, 7, 3.4)
    for k, (name, curve) in enumerate(curves.items()):
        time = np.append(curve.time, max(until, curve.time[-1]))
        share, low, high = (np.append(x, x[-1]) for x in (curve.survival, curve.low, curve.high))
        color = (hue or {}).get(name, PALETTE[(k + 2) % len(PALETTE)])
        ax.fill_between(time, low, high, step="post", color=color, alpha=0.15, lw=0)
        label = f"{name} (n = {curve.at_risk[0]})"
        ax.step(time, share, where="post", color=color, ls=DASHES[k % len(DASHES)], lw=2, label=label)
    ax.set(xlim=(0, until), ylim=(-0.02, 1.04), xlabel="tick", ylabel="fraction surviving", title=title)
    ax.legend(loc="lower left")
    return figure


@styled
def arms(runs: Mapping[str, Sequence[Series]]) -> Figure:
    """Plot population sizes over time in each arm (columns): runs (thin lines) and their median (thick)."""
    first = next(iter(runs.values()))[0]
    hue, labels = colors_of(first), [f"number of {s}" for s in first.species]
    figure, axes = grid_of_arms(runs, labels, (4, 1.9), 0.6, sharey="row")
    for column, members in zip(axes.T, runs.values(), strict=True):
        length = min(len(run.ticks) for run in members)
        for ax, s in zip(column, first.species, strict=True):
            numbers = [thin(run.of(s)[:length], 400)[0] for run in members]
            x = np.linspace(members[0].ticks[0], members[0].ticks[length - 1], len(numbers[0]))
            many_and_one(ax, x, np.array(numbers), np.median(numbers, axis=0), hue[s])
            ax.margins(x=0)
    for ax in axes[:, 0]:
        ax.set_ylim(0, None)  # last, because it ends the automatic scaling of the whole row
    return figure
