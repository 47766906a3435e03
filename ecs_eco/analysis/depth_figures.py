"""Figures for a run with a sun and deep water, and the report section that shows them."""

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.depth import (
    HOURS,
    day_by_hour,
    day_of,
    depth_cycle,
    depths_by_hour,
    depths_over_time,
    hours_of,
    is_night,
    surface_light,
    swimmers,
    water_of,
)
from ecs_eco.analysis.escapes import (
    AROUND,
    REST,
    WITHIN,
    Escape,
    Leaving,
    escapes,
    hunts,
    leaving,
    noses,
    recorded_tracks,
)
from ecs_eco.analysis.page import drawn, number, table
from ecs_eco.analysis.palette import AXIS, NIGHT, SUN
from ecs_eco.analysis.runs import Series, mean_of_there
from ecs_eco.analysis.style import (
    PALETTE,
    Figure,
    colors_of,
    grid_of_arms,
    many_and_one,
    over_ticks,
    panels,
    styled,
)
from ecs_eco.analysis.svg import DIM

NOON = "#fff6d1"


@styled
def mean_depth(series: Series, species: Sequence[str], day: int) -> Figure:
    """Plot mean depth over time, with the surface at the top and the surface light as background."""
    from matplotlib.colors import LinearSegmentedColormap

    figure, ((ax,),) = panels(1, 1, 9.5, 3.6)
    figure.set_gid(DIM)
    hue = colors_of(series)
    time = (series.ticks - series.ticks[0]) / day
    height = water_of(series)
    shade = LinearSegmentedColormap.from_list("light", [NIGHT, NOON])
    light = surface_light(series)
    most = max(1e-9, float(light.max()))
    box = {"extent": (0.0, float(time[-1]), height, 0.0), "aspect": "auto", "interpolation": "nearest"}
    seen = ax.imshow(light[None], cmap=shade, vmin=0, vmax=most, zorder=0, **box)
    for s in species:
        depth = np.where(series.of(s) > 0, series.of(s, "depth_mean"), np.nan)
        ax.plot(time, depth, color="white", lw=3.2, zorder=2)
        ax.plot(time, depth, color=hue[s], lw=1.7, label=s, zorder=3)
    ax.set(xlim=(0, time[-1]), ylim=(height, 0), xlabel="day", ylabel="mean depth [m]")
    ax.grid(visible=False)
    figure.colorbar(seen, ax=ax, label="light at the surface", pad=0.015)
    figure.legend(loc="outside upper left", ncols=len(species))
    return figure


@styled
def by_hour(shares: Mapping[str, np.ndarray], height: float, light: np.ndarray) -> Figure:
    """Plot the fraction of each species by layer (rows) and hour (columns), below a panel of the light f64[n]."""
    figure, axes = panels(
        2, len(shares), 3.5 * len(shares) + 0.9, 4.0, sharex=True, sharey="row", height_ratios=[1, 6]
    )
    top = max(0.05, min(1.0, max(float(np.nanmax(x, initial=0)) for x in shares.values())))
    seen: Any = None
    light = light[np.linspace(0, len(light) - 1, min(len(light), 240)).astype(int)]
    for (above, ax), (s, share) in zip(axes.T, shares.items(), strict=True):
        above.fill_between(np.linspace(0, 24, len(light)), 0, light, color=SUN, lw=0)
        above.set(title=s, ylim=(0, max(1e-9, light.max()) * 1.05), yticks=[])
        edges = np.linspace(0, 24, HOURS + 1), np.linspace(0, height, len(share) + 1)
        seen = ax.pcolormesh(*edges, share, cmap="viridis", vmin=0, vmax=top, rasterized=True)
        ax.set(xlabel="hour of the day", xlim=(0, 24), xticks=[0, 6, 12, 18, 24], ylim=(height, 0))
        ax.grid(visible=False)
    axes[0, 0].set_ylabel("light")
    axes[1, 0].set_ylabel("depth [m]")
    figure.colorbar(seen, ax=axes[1].tolist(), label="fraction of the species", pad=0.015)
    return figure


@styled
def over_time(edges: np.ndarray, numbers: Mapping[str, np.ndarray], height: float) -> Figure:
    """Plot the mean number of each species by layer (rows, surface at the top) and period (columns)."""
    figure, axes = over_ticks(len(numbers), 1.9, 0.6)
    for ax, (s, count) in zip(axes, numbers.items(), strict=True):
        deep, most = np.linspace(0, height, len(count) + 1), max(float(count.max()), 1e-9)
        seen = ax.pcolormesh(edges, deep, count, cmap="viridis", vmin=0, vmax=most, rasterized=True)
        ax.set(title=s, ylabel="depth [m]", ylim=(height, 0), xlim=(edges[0], edges[-1]))
        ax.grid(visible=False)
        figure.colorbar(seen, ax=ax, label="mean number", pad=0.015)
    return figure


@styled
def arms(runs: Mapping[str, Sequence[Series]], species: Sequence[str]) -> Figure:
    """Plot mean depth by hour in each arm (columns) for each species (rows): runs (thin) and means (thick)."""
    first = next(iter(runs.values()))[0]
    hue, labels = colors_of(first), [f"mean depth of {s} [m]" for s in species]
    figure, axes = grid_of_arms(runs, labels, (2.6, 2.3), 0.5, "hour", sharey=True)
    for column, members in zip(axes.T, runs.values(), strict=True):
        for ax, s in zip(column, species, strict=True):
            days = np.array([day_by_hour(run, s) for run in members])
            if day := day_of(members[0]):  # shade hours with less than 1% of the day's maximum light
                ticks = members[0].ticks[0] + np.arange(day)
                order = np.argsort(hours := hours_of(members[0], ticks) * 24)
                dark, whole = is_night(members[0], ticks)[order], ax.get_xaxis_transform()
                night: Any = {"color": NIGHT, "alpha": 0.5, "lw": 0}
                ax.fill_between(hours[order], 0, 1, where=dark, transform=whole, **night)
            many_and_one(ax, np.arange(HOURS) + 0.5, days, mean_of_there(days), hue[s], lw=2.2)
            ax.set(xlim=(0, 24), xticks=[0, 6, 12, 18, 24], ylim=(water_of(first), 0))
            ax.grid(visible=False)
    return figure


@styled
def escape_figure(result: Escape, prey: str, predator: str, dt: float) -> Figure:
    """Plot speed and direction against the time since an approach [s]."""
    figure, axes = panels(1, 2, 8.4, 3.2)
    time = np.arange(-AROUND, AROUND + 1) * dt
    words = f"speed of {prey} [m/s]", f"cosine between movement and\nthe direction away from {predator}"
    for ax, values, word in zip(axes[0], (result.speed, result.away), words, strict=True):
        ax.axvline(0, color=AXIS, lw=1, ls="--")
        ax.plot(time, values, "o-", color=PALETTE[2], ms=4)
        ax.set(xlabel=f"time since the approach of {predator} [s]", ylabel=word)
    axes[0, 0].set_ylim(0, None)
    axes[0, 1].axhline(0, color=AXIS, lw=0.8)
    axes[0, 1].set_ylim(-1, 1)
    return figure


def blocks(run: Path, series: Series, place: Path) -> list[str]:
    """Return the sections on depth, by hour if there is a sun, and write their figures to `place`."""
    day = day_of(series) if len(series.ticks) else 0
    species = swimmers(series) if day else []
    density = list(_density(run, place, series))
    if not species:
        return ["<h2>Depth over time</h2>", *density] if density else []
    head = "<h2>Depth by time of day</h2>"
    shade = "Mean depth over time; the background shows the light at the surface."
    over = drawn(mean_depth(series, species, day), place / "figures" / "depth.svg", shade)
    hours, away = _hours(run, place, series, day), _escapes(run, place, series)
    smells = (
        _leaving(of, *nose) for nose in noses(series.manifest) if (of := leaving(run, *nose)) is not None
    )
    return [head, over, _cycles(series, species), *density, *hours, *away, *smells]


def _density(run: Path, place: Path, series: Series) -> Iterator[str]:
    species = swimmers(series) if "depth_mean" in series.columns and len(series.ticks) else []
    edges, numbers = depths_over_time(run, series, species)
    if species and len(edges) > 2:
        height = water_of(series)
        layer = height / len(numbers[species[0]])
        caption = (
            f"Depth distribution over time: the mean number per {number(layer)} m of depth in the "
            f"snapshots of each period of {number(int(np.diff(edges)[0]))} ticks."
        )
        yield drawn(over_time(edges, numbers, height), place / "figures" / "depths.svg", caption)


def _hours(run: Path, place: Path, series: Series, day: int) -> Iterator[str]:
    shares = depths_by_hour(run, series)
    if any(np.isfinite(share).any() for share in shares.values()):
        ticks = np.arange(day)
        light = surface_light(series, ticks)[np.argsort(hours_of(series, ticks))]
        caption = "Depth of each species by hour of a 24-hour day, excluding the first day."
        yield drawn(by_hour(shares, water_of(series), light), place / "figures" / "hours.svg", caption)


def _escapes(run: Path, place: Path, series: Series) -> Iterator[str]:
    for prey, predator in hunts(series.manifest):
        tracks = recorded_tracks(run, prey, predator)
        result = None if tracks is None else escapes(tracks)
        if result is not None and np.isfinite([result.gain, result.u]).all():
            file = place / "figures" / f"escape-{series.index(prey)}-{series.index(predator)}.svg"
            figure = escape_figure(result, prey, predator, series.dt)
            yield drawn(figure, file, f"{prey} before and after the approach of {predator}.")
            yield _escape(result, prey, predator, series.dt)


def _cycles(series: Series, species: list[str]) -> str:
    head = ["species", "days", "mean depth [m]", "amplitude [m]", "fraction of water depth"]
    head += ["deepest [h after noon]", "p", "r with light"]
    note = (
        "A cosine with a period of one day is fitted to mean depth, excluding the first day; the amplitude "
        "is half the height of the wave. p is the probability of an amplitude at least as large if days "
        "started at random hours; r is the correlation between mean depth and the surface light at the same "
        "time. One run is one replicate."
    )
    return f"{table(head, [_cycle(series, s) for s in species])}<p class='under'>{note}</p>"


def _cycle(series: Series, species: str) -> list[str]:
    if (c := depth_cycle(series, species)) is None:
        return [species, "less than two days", *["–"] * 6]
    p = "–" if np.isnan(c.p) else f"{'≤' if c.p <= 0.001 else '='} {c.p:.2g}"
    wave = number(c.fit.mesor), number(c.fit.amplitude), f"{c.share:.0%}", f"{24 * c.lag:+.1f}"
    return [species, f"{c.days:.0f}", *wave, p, number(c.r)]


def _escape(result: Escape, prey: str, predator: str, dt: float) -> str:
    after = "never" if result.latency is None else f"{result.latency} ticks ({result.latency * dt:g} s)"
    p = "&lt; 0.001" if result.p < 0.001 else f"= {result.p:.2g}"
    prey, predator = escape(prey), escape(predator)
    return (
        f"<p>{result.n:,} approaches of {predator} to {WITHIN} m, each after {REST} ticks without one. The "
        f"speed of {prey} increases {result.gain:.1f}-fold within two ticks. Time to reach twice the "
        f"previous speed, counted from the tick that begins with the approach: {after}. V-test for "
        f"movement away, one tick after the approach: u = {result.u:.1f}, p {p}, treating approaches as "
        f"independent. Animals that are eaten are included until their death. A {predator} that overshoots "
        "also makes the prey appear to move away, which is not an escape.</p>"
    )


def _leaving(result: Leaving, species: str, nose: str) -> str:
    night = f" (at night, {result.night:.2f} for {result.n_night:,} moves)" if result.n_night else ""
    return (
        f"<p>Where {escape(nose.replace('_', ' '))} is detected, {result.n:,} moves of {escape(species)} "
        "have a chemotaxis index (moves down the gradient minus moves up, divided by all moves) of "
        f"{result.index:.2f}{night}. Successive moves of an animal are correlated, so the replicate is the "
        "run.</p>"
    )
