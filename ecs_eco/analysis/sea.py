"""A recorded run under a sun and over a depth: how mean depth follows the day, who is how deep at which hour, and escapes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from ecs_eco.analysis.migration import Cosinor, Record, Tracks, approaches, around, cosinor, event_average, p_of_days, tracks_of, v_test
from ecs_eco.analysis.runs import Series, load_series, parts
from ecs_eco.record import seal
from ecs_eco.record.arrow import read_part
from ecs_eco.space.sun import Sun

HOURS = 24  # parts of a day
WITHIN, REST, AROUND = 1.5, 5, 5  # [m], [ticks], [ticks]: an approach, how long none came before, and what is shown around it


@dataclass(frozen=True)
class DepthCycle:
    """How the mean depth of a species follows the day; the first day is left out."""

    days: float
    fit: Cosinor  # [m] of times in days from noon: the acrophase is how long after noon they are deepest
    height: float  # [m] of the water
    p: float  # that days begun at random hours have as large an amplitude; NaN for less than three whole days
    r: float  # correlation of mean depth with light at the surface

    @property
    def share(self) -> float:
        """Amplitude as a share of the depth of the water."""
        return self.fit.amplitude / self.height

    @property
    def lag(self) -> float:
        """How long after noon they are deepest [days], from -1/2 to 1/2."""
        return ((self.fit.acrophase + np.pi) % (2 * np.pi) - np.pi) / (2 * np.pi)


def day_of(series: Series) -> int:
    """Ticks of a day; 0 where the run has no sun, no depth, or no day in it."""
    config = series.manifest.get("config", {})
    sun = config.get("sun")
    if not sun or "depth_mean" not in series.columns:
        return 0
    day = round(sun["day"] / series.dt)
    return day if 1 < day < len(series.ticks) else 0


def hours_of(series: Series, ticks: np.ndarray) -> np.ndarray:
    """Time of the day at ticks, as a share of it since midnight."""
    sun = series.manifest["config"]["sun"]
    return np.asarray((np.asarray(ticks, float) * series.dt / sun["day"] + sun["start"]) % 1.0)


def _part_of_day(series: Series, ticks: np.ndarray) -> np.ndarray:
    """Which of the HOURS parts of the day ticks fall in: i64; a tick at a full hour, to rounding, begins it."""
    return np.floor(hours_of(series, ticks) * HOURS + 1e-6).astype(np.int64) % HOURS


def surface_light(series: Series, ticks: np.ndarray | None = None) -> np.ndarray:
    """Light at the surface at ticks (all of the run), f64[ticks]; what interventions did to it is not in it."""
    config = series.manifest["config"]
    sun, full = Sun(**config["sun"]), config.get("ambient", {}).get("light", 1.0)
    return np.array([full * sun.light(float(t) * series.dt) for t in (series.ticks if ticks is None else ticks)])


def depth_cycle(series: Series, species: str) -> DepthCycle | None:
    """How the mean depth of a species follows the day; None where it did not live two whole days."""
    day = day_of(series)
    lived = series.of(species) > 0
    end = len(lived) if lived.all() else int(np.argmin(lived))
    if not day or end < 2 * day:
        return None
    depth, ticks = series.of(species, "depth_mean")[day:end], series.ticks[day:end]
    whole = len(depth) // day
    fit = cosinor((hours_of(series, ticks) - 0.5) % 1.0, depth, 1.0)
    light = surface_light(series, ticks)
    r = float(np.corrcoef(depth, light)[0, 1]) if light.std() > 1e-9 and depth.std() > 1e-9 else float("nan")
    p = p_of_days(depth[: whole * day].reshape(whole, day), n=999) if whole > 2 else float("nan")
    return DepthCycle(len(depth) / day, fit, float(series.manifest["config"]["space"]["size"][2]), p, r)


def day_by_hour(series: Series, species: str) -> np.ndarray:
    """Mean depth of a species [m] by hour of the day, f64[HOURS], the first day left out; NaN where none lived at that hour."""
    lived = (series.of(species) > 0) & (series.ticks >= series.ticks[0] + day_of(series))
    hour = _part_of_day(series, series.ticks[lived])
    n = np.bincount(hour, minlength=HOURS)
    return np.bincount(hour, series.of(species, "depth_mean")[lived], HOURS) / np.where(n > 0, n, np.nan)


def mean_of_there(values: np.ndarray) -> np.ndarray:
    """Mean over rows f64[n, k] of what is there: f64[k], NaN where nothing is."""
    there = np.isfinite(values)
    return np.where(there, values, 0.0).sum(0) / np.where(there.any(0), there.sum(0), np.nan)


def swimmers(series: Series) -> list[str]:
    """Species of a run that move by themselves and were there."""
    known = series.manifest.get("config", {}).get("species", {})
    return [s for s, here in zip(series.species, series.present, strict=True) if here and known.get(s, {}).get("locomotion")]


def depths_by_hour(run: Path | str, series: Series, layers: int = 15) -> dict[str, np.ndarray]:
    """Share of each species in each layer by hour, f64[layers, HOURS] by species, from the snapshots; columns without any are NaN.

    The first day is left out.
    """
    top = float(series.manifest["config"]["space"]["size"][2])
    out = {s: np.zeros((layers, HOURS)) for s, here in zip(series.species, series.present, strict=True) if here}
    for file in parts(run, "snapshots"):
        found = read_part(file, ["tick", "species", "z"], seal.has_seals(Path(run)))
        tick, z, name = found["tick"].to_numpy(), found["z"].to_numpy(), found["species"].cast("string").to_numpy(zero_copy_only=False)
        hour = _part_of_day(series, tick)
        layer = np.clip(((top - z) / top * layers).astype(int), 0, layers - 1)
        for s, counts in out.items():
            mine = (name == s) & (tick >= series.ticks[0] + day_of(series))
            np.add.at(counts, (layer[mine], hour[mine]), 1)
    for counts in out.values():
        total = counts.sum(0)
        counts /= np.where(total > 0, total, np.nan)
    return out


# --- escapes -----------------------------------------------------------------------------------------------------------


def hunts(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    """(prey, predator) of animals of which every tick of every organism was recorded: of a sample nobody knows who was near."""
    if manifest.get("record") != "full":
        return []
    kinds = {k.removeprefix("details-") for k, n in manifest.get("parts", {}).items() if k.startswith("details-") and n}
    known = manifest["config"]["species"]
    return [(meal["eats"], name) for name, species in known.items() for meal in species.get("diet", ()) if {name, meal["eats"]} <= kinds]


def recorded_tracks(run: Path | str, prey: str, predator: str, within: float = 10.0, most: int = 3000) -> Tracks | None:
    """Return what prey did in the last `most` ticks of a run with details of prey and predators, None where nobody was together."""
    series = load_series(run)
    config = series.manifest["config"]
    first = int(series.ticks[-1]) - most
    mine, other = (_places(run, name, first) for name in (prey, predator))
    size = [*config["space"]["size"], 0.0][:3]
    space = SimpleNamespace(size=size, torus=config["space"]["edges"] == "torus")
    nobody = (np.zeros(0, np.uint64), np.zeros((0, 3)))
    records: list[Record] = []
    ticks = [t for t in sorted(mine) if t + 1 in mine]
    for tick in ticks:
        distance, offset = _to_nearest(space, mine[tick][1], other.get(tick, nobody)[1], within)
        records.append((mine[tick], distance, offset, mine[tick + 1]))
    return tracks_of(records, surface_light(series, np.array(ticks) + 1), space, series.dt) if records else None


def _places(run: Path | str, name: str, first: int) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """Uids in order and places of a species by tick, from its details."""
    out: dict[int, tuple[np.ndarray, np.ndarray]] = {}
    for file in parts(run, f"details-{name}"):
        found = read_part(file, ["tick", "uid", "x", "y", "z"], seal.has_seals(Path(run)))
        tick, uid = found["tick"].to_numpy(), found["uid"].to_numpy()
        place = np.stack([found[c].to_numpy() for c in "xyz"], 1).astype(float)
        order = np.lexsort((uid, tick))
        order = order[tick[order] >= first]
        cuts = np.flatnonzero(np.diff(tick[order])) + 1
        for rows in np.split(order, cuts) if order.size else ():
            t, before = int(tick[rows[0]]), out.get(int(tick[rows[0]]))  # a tick may end in the next part
            both = (uid[rows], place[rows]) if before is None else (np.append(before[0], uid[rows]), np.append(before[1], place[rows], 0))
            again = np.argsort(both[0])
            out[t] = both[0][again], both[1][again]
    return out


def _to_nearest(space: Any, mine: np.ndarray, other: np.ndarray, within: float) -> tuple[np.ndarray, np.ndarray]:
    if not len(other):
        return np.full(len(mine), np.inf), np.zeros((len(mine), 3))
    d = around(space, (other[None] - mine[:, None]).reshape(-1, 3)).reshape(len(mine), len(other), 3)
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

    The V-test takes approaches as independent; where an animal is approached often it says too much, so runs are the replicates.
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
    u, p = v_test(cosines[np.isfinite(cosines)]) if np.isfinite(cosines).any() else (float("nan"), float("nan"))
    gain = float(np.nanmax(after)) / before if before > 0 and np.isfinite(after).any() else float("nan")
    return Escape(len(events), speed, away, gain, int(fast[0]) if fast.size else None, u, p)


# --- smells ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Leaving:
    """How often moves lead down the gradient of a smell, as a nose feels it: (N down − N up)/N, of all moves and of those by night."""

    n: int
    index: float
    n_night: int
    night: float


def noses(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    """(species, channels without their directions) of noses that compare two sides, of species with details."""
    kinds = {k.removeprefix("details-") for k, n in manifest.get("parts", {}).items() if k.startswith("details-") and n}
    known = {name: species.get("sensors", ()) for name, species in manifest["config"]["species"].items() if name in kinds}
    return [(name, s.get("name") or f"{s['field']}_gradient") for name, all_ in known.items() for s in all_ if s["kind"] == "gradient"]


def leaving(run: Path | str, species: str, nose: str, least: float = 0.1, most: int = 3000) -> Leaving | None:
    """How often a species leaves what it smells, in the last `most` ticks of a run with details; None where nothing was smelt.

    Counted are moves of a tick at whose beginning the gradient that the nose feels is longer than `least`, of 1 at the most.
    """
    series = load_series(run)
    names = ["tick", "uid", "x", "y", "z", "heading", *(f"sensor: {nose}_{way}" for way in ("forward", "left", "up"))]
    blocks = []
    for file in parts(run, f"details-{species}"):
        found = read_part(file, names, seal.has_seals(Path(run)))
        blocks.append([found[name].to_numpy() for name in names])
    if not blocks:
        return None
    tick, uid, *columns = (np.concatenate(column) for column in zip(*blocks, strict=True))
    order = np.lexsort((tick, uid))
    order = order[tick[order] >= int(series.ticks[-1]) - most]
    before, after = order[:-1], order[1:]
    both = (uid[before] == uid[after]) & (tick[after] - tick[before] == 1)  # places are those of the end of a tick
    before, after = before[both], after[both]
    config = series.manifest["config"]
    space = SimpleNamespace(size=[*config["space"]["size"], 0.0][:3], torus=config["space"]["edges"] == "torus")
    x, y, z, heading, forward, left, up = (np.asarray(c, float) for c in columns)
    way = around(space, np.stack([c[after] - c[before] for c in (x, y, z)], 1))
    cos, sin = np.cos(heading[before]), np.sin(heading[before])
    along = (way[:, 0] * cos + way[:, 1] * sin) * forward[after] + (way[:, 1] * cos - way[:, 0] * sin) * left[after] + way[:, 2] * up[after]
    felt = (np.sqrt(forward**2 + left**2 + up**2)[after] > least) & (along != 0)
    night = _is_night(series, tick[after])
    if not felt.any():
        return None
    down, dark = along < 0, felt & night
    of = [(int(those.sum()), float(2 * down[those].mean() - 1) if those.any() else float("nan")) for those in (felt, dark)]
    return Leaving(*of[0], *of[1])


def _is_night(series: Series, ticks: np.ndarray) -> np.ndarray:
    """Whether the light at the surface is less than a hundredth of the run's most."""
    there, place = np.unique(ticks, return_inverse=True)
    light = surface_light(series, there)
    return np.asarray((light < 0.01 * max(float(light.max()), 1e-9))[place])
