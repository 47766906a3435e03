"""Escapes in a recorded run, from approaching predators and from smells."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.depth import is_night, surface_light
from ecs_eco.analysis.runs import load_series, whole_table
from ecs_eco.analysis.tracks import (
    Box,
    Record,
    Tracks,
    Volume,
    approaches,
    event_average,
    shortest,
    tracks_of,
    v_test,
)

WITHIN = 1.5  # distance that counts as an approach [m]
REST, AROUND = 5, 5  # time without an approach before it, and time shown around it [ticks]


def hunts(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return (prey, predator) pairs of species of which details of all organisms were recorded in all ticks."""
    if manifest.get("record") != "full":
        return []
    animals = _detailed(manifest)
    return [
        (meal["eats"], name)
        for name, species in animals.items()
        for meal in species.get("diet", ())
        if meal["eats"] in animals
    ]


def _detailed(manifest: Mapping[str, Any]) -> dict[str, Any]:
    """Return the configuration of each species whose details were recorded."""
    known, kept = manifest["config"]["species"], manifest.get("parts", {})
    return {name: species for name, species in known.items() if kept.get(f"details-{name}")}


def recorded_tracks(
    run: Path | str, prey: str, predator: str, within: float = 10.0, most: int = 3000
) -> Tracks | None:
    """Return tracks of prey in the last `most` ticks of a run with recorded details, or None without any."""
    series = load_series(run)
    first = int(series.ticks[-1]) - most + 1
    mine, other = (_places(run, name, first) for name in (prey, predator))
    space = Box.of(series)
    nobody = (np.zeros(0, np.uint64), np.zeros((0, 3)))
    records: list[Record] = []
    ticks = [t for t in sorted(mine) if t + 1 in mine]
    for tick in ticks:
        distance, offset = _to_nearest(space, mine[tick][1], other.get(tick, nobody)[1], within)
        records.append((mine[tick], distance, offset, mine[tick + 1]))
    return (
        tracks_of(records, surface_light(series, np.array(ticks) + 1), space, series.dt) if records else None
    )


def _places(run: Path | str, name: str, first: int) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """Return the sorted uids and the positions of a species by tick, from tick `first` on."""
    tick, uid, *xyz = _details(run, name, ["tick", "uid", "x", "y", "z"]) or [np.zeros(0)] * 5
    order, place = np.lexsort((uid, tick)), np.stack(xyz, 1).astype(float)
    order = order[tick[order] >= first]
    by_tick = np.split(order, np.flatnonzero(np.diff(tick[order])) + 1)
    return {int(tick[rows[0]]): (uid[rows], place[rows]) for rows in by_tick if len(rows)}


def _details(run: Path | str, name: str, columns: list[str]) -> list[np.ndarray]:
    """Return columns of a species' recorded details; empty if there are none."""
    rows = whole_table(run, f"details-{name}", columns)
    return [rows[column].to_numpy() for column in columns if rows.column_names]


def _to_nearest(
    space: Volume, mine: np.ndarray, other: np.ndarray, within: float
) -> tuple[np.ndarray, np.ndarray]:
    if not len(other):
        return np.full(len(mine), np.inf), np.zeros((len(mine), 3))
    d = shortest(space, (other[None] - mine[:, None]).reshape(-1, 3)).reshape(len(mine), len(other), 3)
    square = (d**2).sum(2)
    best = square.argmin(1)
    distance = np.sqrt(square[np.arange(len(mine)), best])
    return np.where(distance <= within, distance, np.inf), d[np.arange(len(mine)), best]


@dataclass(frozen=True)
class Escape:
    """The behavior of prey around the approach of a predator, by ticks since the approach."""

    n: int
    speed: np.ndarray  # f64[2 AROUND + 1] [m/s]
    away: np.ndarray  # cosine between the prey's movement and the direction away from the predator
    gain: float  # highest speed in the tick of the approach and the next two / mean speed before
    latency: int | None  # ticks until twice the previous speed; None if never
    u: float  # statistic of the V-test of movement directions one tick after the approach
    p: float


def escapes(tracks: Tracks, within: float = WITHIN, rest: int = REST) -> Escape | None:
    """Return the behavior of prey around approaches of predators to `within` [m], or None if there were none. The
    V-test treats approaches as independent, which overstates the evidence: the replicates are runs."""
    events = approaches(tracks.distance, within, rest)
    if not len(events):
        return None
    speed, away = (event_average(x, events, AROUND, AROUND) for x in (tracks.speed, tracks.away))
    before = float(np.nanmean(speed[:AROUND])) if np.isfinite(speed[:AROUND]).any() else np.nan
    after = speed[AROUND : AROUND + 3]
    fast = np.flatnonzero(speed[AROUND:] >= 2 * before)
    later = events[events[:, 0] + 1 < len(tracks.away)]
    cosines = tracks.away[later[:, 0] + 1, later[:, 1]]
    cosines = cosines[np.isfinite(cosines)]
    u, p = v_test(cosines) if len(cosines) else (np.nan, np.nan)
    gain = float(np.nanmax(after)) / before if before > 0 and np.isfinite(after).any() else np.nan
    return Escape(len(events), speed, away, gain, int(fast[0]) if fast.size else None, u, p)


@dataclass(frozen=True)
class Leaving:
    """The tendency to move down a smell gradient, (N down − N up)/N, for all moves and for moves at night."""

    n: int
    index: float
    n_night: int
    night: float


def noses(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return (species, channel name without direction) for each two-sided nose of species with recorded details."""
    return [
        (name, s.get("name") or f"{s['field']}_gradient")
        for name, species in _detailed(manifest).items()
        for s in species.get("sensors", ())
        if s["kind"] == "gradient"
    ]


def leaving(run: Path | str, species: str, nose: str, least: float = 0.1, most: int = 3000) -> Leaving | None:
    """Return how often a species moves away from a smell in the last `most` ticks, or None if none was detected.
    Moves count if the nose measured a gradient above `least` (at most 1) at the beginning of the tick."""
    series = load_series(run)
    smells = (f"sensor: {nose}_{way}" for way in ("forward", "left", "up"))
    names = ["tick", "uid", "x", "y", "z", "heading", *smells]
    if not (found := _details(run, species, names)):
        return None
    tick, uid, *columns = found
    order = np.lexsort((tick, uid))
    order = order[tick[order] > int(series.ticks[-1]) - most]
    before, after = order[:-1], order[1:]
    # positions are from the end of a tick
    both = (uid[before] == uid[after]) & (tick[after] - tick[before] == 1)
    before, after = before[both], after[both]
    x, y, z, heading, forward, left, up = (np.asarray(c, float) for c in columns)
    way = shortest(Box.of(series), np.stack([c[after] - c[before] for c in (x, y, z)], 1))
    cos, sin = np.cos(heading[before]), np.sin(heading[before])
    along = (
        (way[:, 0] * cos + way[:, 1] * sin) * forward[after]
        + (way[:, 1] * cos - way[:, 0] * sin) * left[after]
        + way[:, 2] * up[after]
    )
    felt = (np.sqrt(forward**2 + left**2 + up**2)[after] > least) & (along != 0)
    night = is_night(series, tick[after])
    if not felt.any():
        return None
    down, dark = along < 0, felt & night
    index, at_night = (float(2 * down[of].mean() - 1) if of.any() else np.nan for of in (felt, dark))
    return Leaving(int(felt.sum()), index, int(dark.sum()), at_night)
