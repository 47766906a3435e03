"""Escapes in a recorded run: what prey does around the approach of a predator."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.depth import surface_light
from ecs_eco.analysis.runs import load_series, tables
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

# [m], [ticks], [ticks]: distance of an approach, time without one before it, time shown around it
WITHIN, REST, AROUND = 1.5, 5, 5


def hunts(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    """(prey, predator) of animals with every tick of every organism recorded:
    a sample does not show which were near."""
    if manifest.get("record") != "full":
        return []
    kinds = {
        k.removeprefix("details-")
        for k, n in manifest.get("parts", {}).items()
        if k.startswith("details-") and n
    }
    known = manifest["config"]["species"]
    return [
        (meal["eats"], name)
        for name, species in known.items()
        for meal in species.get("diet", ())
        if {name, meal["eats"]} <= kinds
    ]


def recorded_tracks(
    run: Path | str, prey: str, predator: str, within: float = 10.0, most: int = 3000
) -> Tracks | None:
    """Return tracks of prey in the last `most` ticks of a run with details of prey and predators;
    None if they never met."""
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
    """Uids in order and places of a species by tick, from its details."""
    out: dict[int, tuple[np.ndarray, np.ndarray]] = {}
    for snapshot in tables(run, f"details-{name}", ["tick", "uid", "x", "y", "z"]):
        tick, uid = snapshot["tick"].to_numpy(), snapshot["uid"].to_numpy()
        place = np.stack([snapshot[c].to_numpy() for c in "xyz"], 1).astype(float)
        order = np.lexsort((uid, tick))
        order = order[tick[order] >= first]
        cuts = np.flatnonzero(np.diff(tick[order])) + 1
        for rows in np.split(order, cuts) if order.size else ():
            t, before = int(tick[rows[0]]), out.get(int(tick[rows[0]]))  # a tick may end in the next part
            both = (
                (uid[rows], place[rows])
                if before is None
                else (np.append(before[0], uid[rows]), np.append(before[1], place[rows], 0))
            )
            by_uid = np.argsort(both[0])
            out[t] = both[0][by_uid], both[1][by_uid]
    return out


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
    """What prey did around the approach of a predator, by ticks from it."""

    n: int
    speed: np.ndarray  # f64[2 AROUND + 1] [m/s]
    away: np.ndarray  # cosine between the way and away from the predator
    gain: float  # fastest of the tick of the approach and the next two, over the mean before
    latency: int | None  # ticks until twice the speed before; None: never
    u: float  # of the V-test of the ways one tick after the approach
    p: float


def escapes(tracks: Tracks, within: float = WITHIN, rest: int = REST) -> Escape | None:
    """What prey did around the approach of a predator to `within` [m]; None where none came near.

    The V-test treats approaches as independent, which overstates the evidence if an animal is approached
    often: runs are the replicates.
    """
    events = approaches(tracks.distance, within, rest)
    if not len(events):
        return None
    speed, away = (event_average(x, events, AROUND, AROUND) for x in (tracks.speed, tracks.away))
    before = float(np.nanmean(speed[:AROUND])) if np.isfinite(speed[:AROUND]).any() else float("nan")
    after = speed[AROUND : AROUND + 3]
    fast = np.flatnonzero(speed[AROUND:] >= 2 * before)
    later = events[events[:, 0] + 1 < len(tracks.away)]
    cosines = tracks.away[later[:, 0] + 1, later[:, 1]]
    u, p = (
        v_test(cosines[np.isfinite(cosines)]) if np.isfinite(cosines).any() else (float("nan"), float("nan"))
    )
    gain = float(np.nanmax(after)) / before if before > 0 and np.isfinite(after).any() else float("nan")
    return Escape(len(events), speed, away, gain, int(fast[0]) if fast.size else None, u, p)
