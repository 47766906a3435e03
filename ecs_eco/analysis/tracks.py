"""Tracks of animals near their predators: paths, speeds and reactions."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import erfc, sqrt
from typing import NamedTuple, Protocol, Self

import numpy as np

from ecs_eco.analysis.runs import Series, mean_of_there

Placed = tuple[np.ndarray, np.ndarray]  # sorted uids u64[n], and positions f64[n, 3] [m]
Record = tuple[Placed, np.ndarray, np.ndarray, Placed]


class Volume(Protocol):
    """The geometry that tracks need: the size of the space [m], and whether it is a horizontal torus."""

    @property
    def size(self) -> Sequence[float]: ...
    @property
    def torus(self) -> bool: ...


class Box(NamedTuple):
    """The space of a recorded run."""

    size: Sequence[float]
    torus: bool

    @classmethod
    def of(cls, series: Series) -> Self:
        """Return the space from the manifest, with height 0 for a plane."""
        space = series.manifest["config"]["space"]
        return cls([*space["size"], 0.0][:3], space["edges"] == "torus")


@dataclass
class Tracks:
    """Tracks of all prey animals that ever lived, f64[ticks, animals], NaN while an animal is not alive."""

    uids: np.ndarray  # u64[animals]
    depth: np.ndarray  # at the end of the tick [m]
    speed: np.ndarray  # [m/s] in the tick
    distance: np.ndarray  # to the nearest predator at the beginning of the tick [m], inf if none is near
    away: np.ndarray  # cosine between the movement in the tick and the direction away from it
    # the same for the horizontal direction to the left of that; NaN if the direction away is vertical
    aside: np.ndarray
    light: np.ndarray  # at the surface at the beginning of the tick, f64[ticks]


def tracks_of(records: list[Record], light: np.ndarray, space: Volume, dt: float) -> Tracks:
    """Return tracks from one record per tick: uids and positions before, distance and offset to the nearest
    predator, uids and positions after."""
    uids = np.unique(
        np.concatenate([uid for before, _, _, after in records for uid in (before[0], after[0])])
    )
    depth, speed, near, away, aside = (np.full((len(records), uids.size), np.nan) for _ in range(5))
    for tick, (before, distance, offset, after) in enumerate(records):
        at, then = np.searchsorted(uids, before[0]), np.searchsorted(uids, after[0])
        depth[tick, then] = space.size[2] - after[1][:, 2]
        near[tick, at] = distance
        both, i, j = np.intersect1d(at, then, return_indices=True)
        way = shortest(space, after[1][j] - before[1][i])
        length = np.linalg.norm(way, axis=1)
        speed[tick, both] = length / dt
        left = np.stack([offset[i, 1], -offset[i, 0], np.zeros(i.size)], 1)
        for cosines, direction in ((away, -offset[i]), (aside, left)):
            span = length * np.linalg.norm(direction, axis=1)
            moved = (span > 1e-9) & np.isfinite(distance[i])
            cosines[tick, both[moved]] = (way * direction).sum(1)[moved] / span[moved]
    return Tracks(uids, depth, speed, near, away, aside, light)


def shortest(space: Volume, d: np.ndarray) -> np.ndarray:
    """Return displacements f64[n, 3] [m]; on a torus, the shortest displacements."""
    if space.torus:
        size = np.array(space.size[:2])
        d[:, :2] -= size * np.round(d[:, :2] / size)
    return d


def approaches(distance: np.ndarray, within: float, rest: int) -> np.ndarray:
    """Return each (tick, animal) i64[k, 2] at which a distance falls below `within` after `rest` ticks above."""
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


def event_average(series: np.ndarray, events: np.ndarray, before: int, after: int) -> np.ndarray:
    """Return the mean course of a series f64[ticks, animals] around events (tick, animal) i64[k, 2], without
    ticks outside the record or in which an animal was not alive (NaN): f64[before + 1 + after]."""
    padded = np.pad(series, ((before, after), (0, 0)), constant_values=np.nan)
    return mean_of_there(padded[events[:, :1] + np.arange(before + 1 + after), events[:, 1:]])


def v_test(cosines: np.ndarray) -> tuple[float, float]:
    """Return (u, p) of the V-test for a preferred direction (Zar 2010, section 27.1), from the cosines of the
    angles to it. u is V = n r cos(mean − expected) divided by sqrt(n/2), which is standard normal for random
    directions in a plane. In three dimensions, the cosines have a variance of 1/3 instead of 1/2, which makes
    the test conservative."""
    n = len(cosines)
    u = float(np.sum(cosines)) * sqrt(2 / n)
    return u, erfc(u / sqrt(2)) / 2
