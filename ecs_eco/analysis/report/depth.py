"""What a report says of a run with a sun and a depth of water."""

from __future__ import annotations

from html import escape
from pathlib import Path

import numpy as np

from ecs_eco.analysis import figures, sea, sea_figures
from ecs_eco.analysis.page import number, picture, table
from ecs_eco.analysis.runs import Series


def blocks(run: Path, series: Series) -> list[str]:
    """Figures and statistics of depth by day, and of escapes where single organisms were recorded; none where there is no sun or depth."""
    day = sea.day_of(series) if len(series.ticks) else 0
    who = sea.swimmers(series) if day else []
    if not who:
        return []
    hue = figures.colors(series.species, series.manifest.get("colors"))

    def drawn(name: str, figure: object, caption: str) -> str:
        return picture(figures.save(figure, run / "figures" / f"{name}.png"), caption)  # type: ignore[arg-type]

    caption = "Mean depth over time, on the light at the surface."
    out = ["<h2>Depth and the day</h2>", drawn("depth", sea_figures.mean_depth(series, who, hue, day), caption), _cycles(series, who)]
    shares = sea.depths_by_hour(run, series)
    if any(np.isfinite(x).any() for x in shares.values()):
        ticks = np.arange(day)
        light = sea.surface_light(series, ticks)[np.argsort(sea.hours_of(series, ticks))]
        height = float(series.manifest["config"]["space"]["size"][2])
        words = "Where each species is by hour of the day, of 24 hours. Without the first day."
        out.append(drawn("hours", sea_figures.by_hour(shares, height, light), words))
    for prey, predator in sea.hunts(series.manifest):
        tracks = sea.recorded_tracks(run, prey, predator)
        found = None if tracks is None else sea.escapes(tracks)
        if found is not None and np.isfinite([found.gain, found.u]).all():
            words = _escape(found, prey, predator, series.dt)
            out += [drawn(f"escape-{series.index(prey)}-{series.index(predator)}", sea_figures.escape(found, prey, predator, series.dt),
                          f"{prey} around the approach of {predator}."), words]
    for species, nose in sea.noses(series.manifest):
        if (left := sea.leaving(run, species, nose)) is not None:
            out.append(_leaving(left, species, nose))
    return out


def _cycles(series: Series, who: list[str]) -> str:
    rows = []
    for s in who:
        c = sea.depth_cycle(series, s)
        if c is None:
            rows.append([s, "less than two days", *["–"] * 6])
            continue
        p = "–" if np.isnan(c.p) else f"{'≤' if c.p <= 0.001 else '='} {c.p:.2g}"
        rows.append(
            [s, f"{c.days:.0f}", number(c.fit.mesor), number(c.fit.amplitude), f"{c.share:.0%}", f"{24 * c.lag:+.1f}", p, number(c.r)]
        )
    head = ["species", "days", "mean depth [m]", "amplitude [m]", "of the water", "deepest, hours of 24 after noon", "p", "r with light"]
    note = (
        "A cosine of one day fitted to mean depth, without the first day; the amplitude is half of the height of the wave. p is how often "
        "days begun at random hours have as large an amplitude; r correlates mean depth with the light at the surface at the same time. "
        "One run is one replicate."
    )
    return f"{table(head, rows)}<p class='under'>{note}</p>"


def _escape(found: sea.Escape, prey: str, predator: str, dt: float) -> str:
    after = "never" if found.latency is None else f"after {found.latency} ticks ({found.latency * dt:g} s)"
    p = "&lt; .001" if found.p < 0.001 else f"= {found.p:.2g}"
    return (
        f"<p>{found.n:,} approaches of {escape(predator)} to {sea.WITHIN} m, none in the {sea.REST} ticks before. Speed of {escape(prey)} "
        f"rises {found.gain:.1f}-fold within two ticks; it is twice that before {after}, counted from the tick that begins with the "
        f"approach. Ways one tick later point away: V-test u = {found.u:.1f}, p {p}, approaches taken as independent. Who is eaten "
        f"counts until then. Ways point away, too, from a {escape(predator)} that overshoots: that alone is no escape.</p>"
    )


def _leaving(found: sea.Leaving, species: str, nose: str) -> str:
    night = f", by night {found.night:.2f} of {found.n_night:,}" if found.n_night else ""
    return (
        f"<p>Where {escape(nose.replace('_', ' '))} is felt, {found.n:,} moves of {escape(species)} have a chemotaxis index (down less up, "
        f"over all) of {found.index:.2f}{night}. Moves of one animal follow each other: the run is the replicate.</p>"
    )
