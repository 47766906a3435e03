"""The part of a report on a run with a sun and a depth of water."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.analysis import depth, depth_figures, figures
from ecs_eco.analysis.chemotaxis import Leaving, leaving, noses
from ecs_eco.analysis.escapes import REST, WITHIN, Escape, escapes, hunts, recorded_tracks
from ecs_eco.analysis.page import number, picture, table
from ecs_eco.analysis.runs import Series

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def blocks(run: Path, series: Series, place: Path) -> list[str]:
    """Depth over time, by day where there is a sun, and escapes and smells where single organisms were
    recorded; nothing without a depth.

    Figures are written below `place`.
    """
    day = depth.day_of(series) if len(series.ticks) else 0
    species = depth.swimmers(series) if day else []
    density = list(_density(run, place, series))
    if not species:
        return ["<h2>Depth over time</h2>", *density] if density else []
    head = "<h2>Depth and the day</h2>"
    days, hours = _days(place, series, species, day), _hours(run, place, series, day)
    return [head, *days, *density, *hours, *_escapes(run, place, series), *_smells(run, series)]


def _drawn(place: Path, name: str, figure: Figure, caption: str) -> str:
    return picture(figures.save_svg(figure, place / "figures" / f"{name}.svg"), caption)


def _density(run: Path, place: Path, series: Series) -> Iterator[str]:
    species = depth.swimmers(series) if "depth_mean" in series.columns and len(series.ticks) else []
    edges, numbers = depth.depths_over_time(run, series, species)
    if species and len(edges) > 2:
        height = float(series.manifest["config"]["space"]["size"][2])
        layer = height / len(numbers[species[0]])
        caption = (
            f"Where they are over time: the mean number in each {number(layer)} m of depth, "
            f"in stretches of {number(int(np.diff(edges)[0]))} ticks, of the snapshots in each."
        )
        yield _drawn(place, "depths", depth_figures.over_time(edges, numbers, height), caption)


def _days(place: Path, series: Series, species: list[str], day: int) -> Iterator[str]:
    hue = figures.colors(series.species, series.manifest.get("colors"))
    figure = depth_figures.mean_depth(series, species, hue, day)
    yield _drawn(place, "depth", figure, "Mean depth over time; the background is the light at the surface.")
    yield _cycles(series, species)


def _hours(run: Path, place: Path, series: Series, day: int) -> Iterator[str]:
    shares = depth.depths_by_hour(run, series)
    if any(np.isfinite(share).any() for share in shares.values()):
        ticks = np.arange(day)
        light = depth.surface_light(series, ticks)[np.argsort(depth.hours_of(series, ticks))]
        height = float(series.manifest["config"]["space"]["size"][2])
        caption = "Depth of each species by hour of the day, of 24 hours, without the first day."
        yield _drawn(place, "hours", depth_figures.by_hour(shares, height, light), caption)


def _escapes(run: Path, place: Path, series: Series) -> Iterator[str]:
    for prey, predator in hunts(series.manifest):
        tracks = recorded_tracks(run, prey, predator)
        result = None if tracks is None else escapes(tracks)
        if result is not None and np.isfinite([result.gain, result.u]).all():
            name = f"escape-{series.index(prey)}-{series.index(predator)}"
            figure = depth_figures.escape(result, prey, predator, series.dt)
            yield _drawn(place, name, figure, f"{prey} around the approach of {predator}.")
            yield _escape(result, prey, predator, series.dt)


def _smells(run: Path, series: Series) -> Iterator[str]:
    for species, nose in noses(series.manifest):
        result = leaving(run, species, nose)
        if result is not None:
            yield _leaving(result, species, nose)


def _cycles(series: Series, species: list[str]) -> str:
    head = [
        "species",
        "days",
        "mean depth [m]",
        "amplitude [m]",
        "of the water",
        "deepest, hours of 24 after noon",
        "p",
        "r with light",
    ]
    note = (
        "A cosine of one day is fitted to mean depth, without the first day; the amplitude is half of the "
        "height of the wave. p is how often days that begin at random hours have an amplitude as large; "
        "r correlates mean depth with the light at the surface at the same time. One run is one replicate."
    )
    return f"{table(head, [_cycle(series, s) for s in species])}<p class='under'>{note}</p>"


def _cycle(series: Series, species: str) -> list[str]:
    c = depth.depth_cycle(series, species)
    if c is None:
        return [species, "less than two days", *["–"] * 6]
    p = "–" if np.isnan(c.p) else f"{'≤' if c.p <= 0.001 else '='} {c.p:.2g}"
    return [
        species,
        f"{c.days:.0f}",
        number(c.fit.mesor),
        number(c.fit.amplitude),
        f"{c.share:.0%}",
        f"{24 * c.lag:+.1f}",
        p,
        number(c.r),
    ]


def _escape(result: Escape, prey: str, predator: str, dt: float) -> str:
    after = "never" if result.latency is None else f"after {result.latency} ticks ({result.latency * dt:g} s)"
    p = "&lt; .001" if result.p < 0.001 else f"= {result.p:.2g}"
    prey, predator = escape(prey), escape(predator)
    return (
        f"<p>{result.n:,} approaches of {predator} to {WITHIN} m, each after {REST} ticks without one. "
        f"The speed of {prey} rises {result.gain:.1f}-fold within two ticks; it reaches twice the previous "
        f"speed {after}, counted from the tick that begins with the approach. One tick later they move away: "
        f"V-test u = {result.u:.1f}, p {p}, treating approaches as independent. Animals that are eaten count "
        f"until then. Prey also moves away from a {predator} that overshoots: that alone is no escape.</p>"
    )


def _leaving(result: Leaving, species: str, nose: str) -> str:
    night = f", by night {result.night:.2f} of {result.n_night:,}" if result.n_night else ""
    return (
        f"<p>Where {escape(nose.replace('_', ' '))} is felt, {result.n:,} moves of {escape(species)} have a "
        f"chemotaxis index (down less up, over all) of {result.index:.2f}{night}. "
        "Moves of one animal follow each other: the run is the replicate.</p>"
    )
