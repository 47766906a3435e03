"""Diel vertical migration, escape and chemotaxis: what is measured of animals in water, and how it is tested."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ecs_eco.components import Position
from ecs_eco.space.nearest import nearest

Placed = tuple[np.ndarray, np.ndarray]  # uids u64[n] in order, and places f64[n, 3] [m]
Record = tuple[Placed, np.ndarray, np.ndarray, Placed]


@dataclass(frozen=True)
class Cosinor:
    """A cosine fitted to a series by least squares (Nelson et al. 1979): mesor + amplitude × cos(2π t/period − acrophase)."""

    mesor: float
    amplitude: float  # half of the difference between highest and lowest
    acrophase: float  # [rad] in [0, 2π): 2π × time of the highest value / period

    @property
    def vector(self) -> np.ndarray:
        """The coefficients of cosine and sine, f64[2]: vectors of several runs can be averaged, acrophases cannot."""
        return self.amplitude * np.array([np.cos(self.acrophase), np.sin(self.acrophase)])


def cosinor(times: np.ndarray, values: np.ndarray, period: float) -> Cosinor:
    """Fit a cosine of a known period to values f64[n] at times f64[n]."""
    angle = 2 * np.pi * np.asarray(times, float) / period
    design = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], 1)
    mesor, a, b = np.linalg.lstsq(design, np.asarray(values, float), rcond=None)[0]
    return Cosinor(float(mesor), float(np.hypot(a, b)), float(np.arctan2(b, a) % (2 * np.pi)))


def mean_cosinor(fits: list[Cosinor]) -> Cosinor:
    """Return the population-mean cosinor of several runs: the mean of their vectors."""
    a, b = np.mean([f.vector for f in fits], axis=0)
    return Cosinor(float(np.mean([f.mesor for f in fits])), float(np.hypot(a, b)), float(np.arctan2(b, a) % (2 * np.pi)))


def p_common_phase(fits: list[Cosinor], n: int = 9999, seed: int = 1) -> float:
    """Return how often runs of random phases have a mean vector as long as these: runs are the replicates; at least 1/(n + 1)."""
    vectors = np.array([f.vector for f in fits])
    angle = np.random.default_rng(seed).uniform(0, 2 * np.pi, (n, len(fits)))
    length, turn = np.hypot(*vectors.T), np.arctan2(vectors[:, 1], vectors[:, 0])
    chance = np.hypot((length * np.cos(turn + angle)).mean(1), (length * np.sin(turn + angle)).mean(1))
    return float((1 + (chance >= np.hypot(*vectors.mean(0)) - 1e-12).sum()) / (n + 1))


def p_of_days(days: np.ndarray, n: int = 9999, seed: int = 1) -> float:
    """Return how often days f64[days, hours], each begun at a random hour, give a mean day of as large an amplitude.

    Whole days are turned, so that what is correlated within a day stays so. A straight line through all days is taken out first: a
    drift makes the same sawtooth of every day.
    """
    rng, (many, hours) = np.random.default_rng(seed), np.shape(days)
    time = np.arange(many * hours)
    level = np.ravel(np.asarray(days, float))
    level = level - np.polyval(np.polyfit(time, level, 1), time) if many > 1 else level
    wave = np.exp(2j * np.pi * np.arange(hours) / hours)
    each = level.reshape(many, hours) @ wave
    turned = each * np.exp(2j * np.pi * rng.integers(0, hours, (n, many)) / hours)
    return float((1 + (np.abs(turned.mean(1)) >= abs(each.mean()) - 1e-9).sum()) / (n + 1))


def event_average(series: np.ndarray, events: np.ndarray, before: int, after: int) -> np.ndarray:
    """Return the mean of windows of a series f64[ticks, animals] around events i64[k, 2] of (tick, animal): f64[before + 1 + after].

    Where an animal did not live (NaN), or the record ends, it is left out.
    """
    windows = np.full((len(events), before + 1 + after), np.nan)
    for i, (tick, animal) in enumerate(events):
        first, last = max(tick - before, 0), min(tick + after + 1, len(series))
        windows[i, first - tick + before : last - tick + before] = series[first:last, animal]
    there = ~np.isnan(windows)
    return np.where(there, windows, 0.0).sum(0) / np.where(there.any(0), there.sum(0), np.nan)


def approaches(distance: np.ndarray, within: float, rest: int) -> np.ndarray:
    """Return (tick, animal) i64[k, 2] where a distance f64[ticks, animals] falls below `within`, after at least `rest` ticks above it."""
    near = distance < within
    events = []
    for animal in range(near.shape[1]):
        last = -rest - 1
        for tick in np.flatnonzero(near[:, animal]).tolist():
            known = tick > 0 and not np.isnan(distance[max(tick - rest, 0) : tick, animal]).any()
            if known and tick - last > rest and tick >= rest:
                events.append((tick, animal))
            last = tick
    return np.array(events, np.int64).reshape(-1, 2)


def v_test(cosines: np.ndarray) -> tuple[float, float]:
    """Return (u, p) of the V-test that directions point one way rather than any (Zar 2010, section 27.1), from their cosines with it.

    u is V = n r cos(mean − expected) over sqrt(n/2), which is normal for directions at random in a plane. In space cosines
    have the variance 1/3 in place of 1/2, so there the test errs on the side of no effect.
    """
    from math import erfc, sqrt

    n = len(cosines)
    u = float(np.sum(cosines)) * sqrt(2 / n)
    return u, erfc(u / sqrt(2)) / 2


def chemotaxis_index(away: int, toward: int) -> float:
    """Return (N away − N toward)/N: 1 where all leave the source, 0 where as many come nearer."""
    return (away - toward) / (away + toward) if away + toward else float("nan")


@dataclass
class Tracks:
    """What prey did, f64[ticks, animals], NaN where an animal did not live; the animals are those that ever lived."""

    uids: np.ndarray  # u64[animals]
    depth: np.ndarray  # [m] at the end of the tick
    speed: np.ndarray  # [m/s] in the tick
    distance: np.ndarray  # [m] to the nearest predator at the beginning of the tick, inf where none is near
    away: np.ndarray  # cosine of the angle between the way in the tick and away from that predator
    aside: np.ndarray  # the same with the level direction to the left of away; NaN where away is straight up or down
    light: np.ndarray  # f64[ticks] at the surface, at the beginning of the tick

    @property
    def mean_depth(self) -> np.ndarray:
        """Mean over the living: f64[ticks], NaN where none lives."""
        there = ~np.isnan(self.depth)
        return np.where(there, self.depth, 0).sum(1) / np.where(there.any(1), there.sum(1), np.nan)


def follow(world: Any, ticks: int, prey: str = "copepod", predator: str = "krill", within: float = 10.0,
           each: Callable[[Any], None] | None = None) -> Tracks:
    """Let a world live for some ticks and record what each of the prey does, and where the nearest predator within 10 m is.

    `each(world)` is called before each tick: an experimenter who moves things.
    """
    top = np.full(1, np.nextafter(world.space.lengths[2], np.float32(0)), np.float32)
    records: list[Record] = []
    light = np.empty(ticks)
    for tick in range(ticks):
        if each is not None:
            each(world)
        light[tick] = world.surroundings("light", top * 0, top * 0, top)[0]
        before = _where(world, prey)
        distance, offset = _nearest(world, prey, predator, within)
        world.step()
        records.append((before, distance, offset, _where(world, prey)))
    return tracks_of(records, light, world.space, world.dt)


def tracks_of(records: list[Record], light: np.ndarray, space: Any, dt: float) -> Tracks:
    """Return the tracks of ticks, each (uids and places before, distance and offset to the predator, uids and places after)."""
    uids = np.unique(np.concatenate([uid for before, _, _, after in records for uid in (before[0], after[0])]))
    columns = [np.full((len(records), uids.size), np.nan) for _ in range(5)]
    for tick, (before, distance, offset, after) in enumerate(records):
        _write(space, dt, columns, tick, np.searchsorted(uids, before[0]), np.searchsorted(uids, after[0]), before, distance, offset, after)
    depth, speed, near, away, aside = columns
    return Tracks(uids, depth, speed, near, away, aside, light)


def _where(world: Any, name: str) -> tuple[np.ndarray, np.ndarray]:
    table = world.tables[name]
    rows, p = table.by_uid(), table[Position]
    return table.uid[rows], np.stack([p.x[rows], p.y[rows], p.z[rows]], 1).astype(float)


def _nearest(world: Any, prey: str, predator: str, within: float) -> tuple[np.ndarray, np.ndarray]:
    """Return distance f64[n] and offset f64[n, 3] to the nearest predator of each of the prey, in the order of uids."""
    mine, other = world.index(world.tables[prey]), world.index(world.tables[predator])
    found, square = np.empty(mine.n, np.int32), np.empty(mine.n, np.float32)
    nearest(mine, other, within, found, square)
    order = np.argsort(mine.uid[: mine.n])
    found, j = found[order], np.maximum(found[order], 0)
    d = np.stack([t[j] - o[order] for t, o in ((other.x, mine.x), (other.y, mine.y), (other.z, mine.z))], 1).astype(float) \
        if other.n else np.zeros((mine.n, 3))
    return np.where(found >= 0, np.sqrt(square[order]), np.inf), around(world.space, d)


def around(space: Any, d: np.ndarray) -> np.ndarray:
    """Return ways f64[n, 3] [m], on a torus the shortest."""
    if space.torus:
        size = np.array(space.size[:2])
        d[:, :2] -= size * np.round(d[:, :2] / size)
    return d


def _write(space: Any, dt: float, columns: list[np.ndarray], tick: int, at: np.ndarray, then: np.ndarray, before: Placed,
           distance: np.ndarray, offset: np.ndarray, after: Placed) -> None:
    depth, speed, near, away, aside = columns
    depth[tick, then] = space.size[2] - after[1][:, 2]
    near[tick, at] = distance
    both, i, j = np.intersect1d(at, then, return_indices=True)
    way = around(space, after[1][j] - before[1][i])
    length = np.linalg.norm(way, axis=1)
    speed[tick, both] = length / dt
    left = np.stack([offset[i, 1], -offset[i, 0], np.zeros(i.size)], 1)
    for cosines, direction in ((away, -offset[i]), (aside, left)):
        span = length * np.linalg.norm(direction, axis=1)
        moved = (span > 1e-9) & np.isfinite(distance[i])
        cosines[tick, both[moved]] = (way * direction).sum(1)[moved] / span[moved]
