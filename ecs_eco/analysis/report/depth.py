"""What a report says of a run with a sun and a depth of water."""

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
    """Depth by day, and escapes and smells where single organisms were recorded; nothing without a sun or a depth.

    Figures are written below `place`.
    """
    day = depth.day_of(series) if len(series.ticks) else 0
    species = depth.swimmers(series) if day else []
    if not species:
        return []
    head = "<h2>Depth and the day</h2>"
    days, hours = _days(place, series, species, day), _hours(run, place, series, day)
    return [head, *days, *hours, *_escapes(run, place, series), *_smells(run, series)]


def _drawn(place: Path, name: str, figure: Figure, caption: str) -> str:
    return picture(figures.save(figure, place / "figures" / f"{name}.png"), caption)


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
        caption = "Where each species is by hour of the day, of 24 hours. Without the first day."
        yield _drawn(place, "hours", depth_figures.by_hour(shares, height, light), caption)


def _escapes(run: Path, place: Path, series: Series) -> Iterator[str]:
    for prey, predator in hunts(series.manifest):
        tracks = recorded_tracks(run, prey, predator)
        found = None if tracks is None else escapes(tracks)
        if found is not None and np.isfinite([found.gain, found.u]).all():
            name = f"escape-{series.index(prey)}-{series.index(predator)}"
            figure = depth_figures.escape(found, prey, predator, series.dt)
            yield _drawn(place, name, figure, f"{prey} around the approach of {predator}.")
            yield _escape(found, prey, predator, series.dt)


def _smells(run: Path, series: Series) -> Iterator[str]:
    for species, nose in noses(series.manifest):
        found = leaving(run, species, nose)
        if found is not None:
            yield _leaving(found, species, nose)


def _cycles(series: Series, species: list[str]) -> str:
    head = ["species", "days", "mean depth [m]", "amplitude [m]", "of the water", "deepest, hours of 24 after noon", "p", "r with light"]
    note = (
        "A cosine of one day is fitted to mean depth, without the first day; the amplitude is half of the height of the wave. "
        "p is how often days that begin at random hours have an amplitude as large; r correlates mean depth with the light at "
        "the surface at the same time. One run is one replicate."
    )
    return f"{table(head, [_cycle(series, s) for s in species])}<p class='under'>{note}</p>"


def _cycle(series: Series, species: str) -> list[str]:
    c = depth.depth_cycle(series, species)
    if c is None:
        return [species, "less than two days", *["–"] * 6]
    p = "–" if np.isnan(c.p) else f"{'≤' if c.p <= 0.001 else '='} {c.p:.2g}"
    return [species, f"{c.days:.0f}", number(c.fit.mesor), number(c.fit.amplitude), f"{c.share:.0%}", f"{24 * c.lag:+.1f}", p, number(c.r)]


def _escape(found: Escape, prey: str, predator: str, dt: float) -> str:
    after = "never" if found.latency is None else f"after {found.latency} ticks ({found.latency * dt:g} s)"
    p = "&lt; .001" if found.p < 0.001 else f"= {found.p:.2g}"
    prey, predator = escape(prey), escape(predator)
    return (
        f"<p>{found.n:,} approaches of {predator} to {WITHIN} m, each after {REST} ticks without one. The speed of {prey} rises "
        f"{found.gain:.1f}-fold within two ticks; it reaches twice the speed before {after}, counted from the tick that begins "
        f"with the approach. One tick later their ways point away: V-test u = {found.u:.1f}, p {p}, taking approaches as "
        f"independent. Those who are eaten count until then. Ways also point away from a {predator} that overshoots: that alone "
        "is no escape.</p>"
    )


def _leaving(found: Leaving, species: str, nose: str) -> str:
    night = f", by night {found.night:.2f} of {found.n_night:,}" if found.n_night else ""
    return (
        f"<p>Where {escape(nose.replace('_', ' '))} is felt, {found.n:,} moves of {escape(species)} have a chemotaxis index (down "
        f"less up, over all) of {found.index:.2f}{night}. Moves of one animal follow each other: the run is the replicate.</p>"
    )
