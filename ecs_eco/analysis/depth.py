"""Depth of organisms in a recorded run with a sun and water: daily cycle, and distribution by hour."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ecs_eco.analysis.rhythm import Cosinor, cosinor, p_of_days
from ecs_eco.analysis.runs import Series, tables

HOURS = 24  # parts of a day


@dataclass(frozen=True)
class DepthCycle:
    """The daily cycle of a species' mean depth, excluding the first day."""

    days: float
    fit: Cosinor  # depth [m] against days since noon: the acrophase is the time of greatest depth
    height: float  # water depth [m]
    p: float  # p value against days that begin at random hours; NaN for fewer than three whole days
    r: float  # correlation of mean depth with light at the surface

    @property
    def share(self) -> float:
        """Amplitude as a fraction of the water depth."""
        return self.fit.amplitude / self.height

    @property
    def lag(self) -> float:
        """Time after noon at which the species is deepest [days], from -1/2 to 1/2."""
        return ((self.fit.acrophase + np.pi) % (2 * np.pi) - np.pi) / (2 * np.pi)


def water_of(series: Series) -> float:
    """Return the water depth [m]."""
    return float(series.manifest["config"]["space"]["size"][2])


def day_of(series: Series) -> int:
    """Return the number of ticks in a day, or 0 if the run has no sun or depth, or is shorter than a day."""
    config = series.manifest.get("config", {})
    sun = config.get("sun")
    if not sun or "depth_mean" not in series.columns:
        return 0
    day = round(sun["day"] / series.dt)
    return day if 1 < day < len(series.ticks) else 0


def hours_of(series: Series, ticks: np.ndarray) -> np.ndarray:
    """Return the time of day at each tick, as the fraction of a day since midnight."""
    sun = series.manifest["config"]["sun"]
    return np.asarray((np.asarray(ticks, float) * series.dt / sun["day"] + sun["start"]) % 1.0)


def _part_of_day(series: Series, ticks: np.ndarray) -> np.ndarray:
    """Return the hour of the day for each tick: i64. A tick on the hour belongs to the hour it begins."""
    return np.floor(hours_of(series, ticks) * HOURS + 1e-6).astype(np.int64) % HOURS


def surface_light(series: Series, ticks: np.ndarray | None = None) -> np.ndarray:
    """Return the surface light at each of these ticks (default: all), ignoring interventions: f64[ticks]."""
    from ecs_eco.space.sun import Sun  # loads numba

    config = series.manifest["config"]
    sun, full = Sun(**config["sun"]), config.get("ambient", {}).get("light", 1.0)
    return np.array(
        [full * sun.light(float(t) * series.dt) for t in (series.ticks if ticks is None else ticks)]
    )


def depth_cycle(series: Series, species: str) -> DepthCycle | None:
    """Return the daily cycle of a species' mean depth.

    Parameters
    ----------
    series : Series
        A run with a sun and water.
    species : str

    Returns
    -------
    DepthCycle or None
        None if the species lived for less than two whole days.

    Examples
    --------
    >>> import numpy as np
    >>> from dataclasses import replace
    >>> from ecs_eco.analysis.depth import depth_cycle
    >>> from ecs_eco.analysis.runs import load_series
    >>> config = {"sun": {"day": 24, "start": 0.0}, "space": {"size": [9, 9, 60]}}
    >>> series = load_series({"krill": np.full(96, 50)})
    >>> depth = 30 - 10 * np.cos(2 * np.pi * np.arange(96) / 24)
    >>> columns = series.columns | {"depth_mean": depth[:, None]}
    >>> series = replace(series, manifest={"config": config}, columns=columns)
    >>> round(depth_cycle(series, "krill").fit.amplitude, 3)
    10.0
    """
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
    return DepthCycle(len(depth) / day, fit, water_of(series), p, r)


def day_by_hour(series: Series, species: str) -> np.ndarray:
    """Return a species' mean depth by hour of the day, excluding the first day.

    Parameters
    ----------
    series : Series
        A run with a sun and water.
    species : str

    Returns
    -------
    array of float64, shape (24,)
        [m]; NaN for hours in which the species was absent.

    Examples
    --------
    >>> import numpy as np
    >>> from dataclasses import replace
    >>> from ecs_eco.analysis.depth import day_by_hour
    >>> from ecs_eco.analysis.runs import load_series
    >>> config = {"sun": {"day": 24, "start": 0.0}, "space": {"size": [9, 9, 60]}}
    >>> series = load_series({"krill": np.full(96, 50)})
    >>> depth = 30 - 10 * np.cos(2 * np.pi * np.arange(96) / 24)
    >>> columns = series.columns | {"depth_mean": depth[:, None]}
    >>> series = replace(series, manifest={"config": config}, columns=columns)
    >>> day_by_hour(series, "krill")[[0, 12]].round(3).tolist()
    [20.0, 40.0]
    """
    lived = (series.of(species) > 0) & (series.ticks >= series.ticks[0] + day_of(series))
    hour = _part_of_day(series, series.ticks[lived])
    n = np.bincount(hour, minlength=HOURS)
    return np.bincount(hour, series.of(species, "depth_mean")[lived], HOURS) / np.where(n > 0, n, np.nan)


def swimmers(series: Series) -> list[str]:
    """Return the species of a run that were present and can move."""
    known = series.manifest.get("config", {}).get("species", {})
    return [s for s in series.there if known.get(s, {}).get("locomotion")]


def depths_by_hour(run: Path | str, series: Series, layers: int = 15) -> dict[str, np.ndarray]:
    """Return the fraction of each species by layer and hour, f64[layers, HOURS], in the snapshots after the first
    day; NaN for hours without snapshots."""
    top = water_of(series)
    out = {s: np.zeros((layers, HOURS)) for s in series.there}
    for tick, layer, name in _snapshots(run, top, layers):
        hour = _part_of_day(series, tick)
        for s, counts in out.items():
            mine = (name == s) & (tick >= series.ticks[0] + day_of(series))
            np.add.at(counts, (layer[mine], hour[mine]), 1)
    for counts in out.values():
        total = counts.sum(0)
        counts /= np.where(total > 0, total, np.nan)
    return out


def _snapshots(run: Path | str, top: float, layers: int) -> Iterator[tuple[np.ndarray, ...]]:
    """Yield, file by file, the tick, layer (from the surface down) and species of organisms in snapshots."""
    for rows in tables(run, "snapshots", ["tick", "species", "z"]):
        layer = np.clip(((top - rows["z"].to_numpy()) / top * layers).astype(int), 0, layers - 1)
        yield (rows["tick"].to_numpy(), layer, rows["species"].to_numpy(zero_copy_only=False))


def depths_over_time(
    run: Path | str, series: Series, species: Sequence[str], layers: int = 20, most: int = 120
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the ticks of at most `most` + 1 bin edges, and by species the mean number of organisms in each layer
    of the snapshots, f64[layers, bins]; there are no bins if the run has no snapshots or no depth."""
    size = series.manifest.get("config", {}).get("space", {}).get("size", ())
    found = list(_snapshots(run, float(size[2]), layers)) if len(size) > 2 and size[2] > 0 else []
    if not any(len(tick) for tick, _, _ in found):
        return np.zeros(1, np.int64), {s: np.zeros((layers, 0)) for s in species}
    tick, layer, name = (np.concatenate(column) for column in zip(*found, strict=True))
    ticks, at = np.unique(tick, return_inverse=True)
    each = -(-len(ticks) // most)  # snapshots per bin
    first = ticks[::each]
    bins, shape = layer * len(first) + at // each, (layers, len(first))
    n = np.bincount(np.arange(len(ticks)) // each)
    numbers = {s: np.bincount(bins, name == s, layers * len(first)).reshape(shape) / n for s in species}
    step = int(np.diff(ticks)[-1]) if len(ticks) > 1 else 1
    return np.append(first, ticks[-1] + step), numbers


def is_night(series: Series, ticks: np.ndarray) -> np.ndarray:
    """Return whether the light at the surface is less than 1% of its maximum over these ticks."""
    there, place = np.unique(ticks, return_inverse=True)
    light = surface_light(series, there)
    return np.asarray((light < 0.01 * max(float(light.max()), 1e-9))[place])
