"""Compare a few statistics of a run with those of the measurements in its world's [data]."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ecs_eco.analysis.against import numbers_of
from ecs_eco.analysis.runs import Series
from ecs_eco.analysis.signature import cycle, period_of
from ecs_eco.config import WorldConfig
from ecs_eco.config.measurements import Outside, outside_of
from ecs_eco.engine.errors import refusal

SKIP = 0.1  # fraction of a run left out at its start

Statistics = dict[str, float]


@dataclass(frozen=True)
class Fit:
    """Measurements to compare runs with, and their statistics: log10 values or fractions of a period.

    Attributes
    ----------
    outside : Outside
        The measurements.
    kinds : tuple of str
        Kinds of statistics compared: "period", "lag", "amplitude", "mean".
    observed : dict of str to float
        Statistics of the measurements.
    """

    outside: Outside
    kinds: tuple[str, ...]
    observed: Statistics
    sha256: str  # of the measurements

    def of(self, series: Series) -> Statistics | None:
        """Return the statistics of the last part of a run, as long as the measurements and sampled like them.

        Parameters
        ----------
        series : Series

        Returns
        -------
        dict of str to float or None
            None if the run is too short, or a species died out in that part.
        """
        x = sampled(series, self.outside)
        return None if x is None else statistics(x, list(self.outside.columns), self.outside, self.kinds)

    def differences(self, own: Mapping[str, float]) -> np.ndarray:
        """Return the differences between a run's statistics and those of the measurements.

        Parameters
        ----------
        own : Mapping of str to float
            Statistics as returned by `of`.

        Returns
        -------
        array of float64, shape (statistics,)
            Differences between lags are taken the shorter way around a period.
        """
        apart = [(name, own[name] - value) for name, value in self.observed.items()]
        return np.array([(d + 0.5) % 1 - 0.5 if name.startswith("lag ") else d for name, d in apart])


def fit_of(config: WorldConfig, ticks: int) -> Fit | None:
    """Return the comparison for a world's goal "data", with runs of this many ticks, or None without this goal.
    Raises ConfigError if the measurements cannot be used or are longer than the runs."""
    if config.data is None or not any(of == "data" for of, _ in config.search.goals):
        return None
    names = [*config.species, *config.reporters]
    outside = outside_of(config.data.model_dump(), config.folder, names, config._source)
    least = 0.0 if outside.ticks is None else float(np.ptp(outside.times)) * outside.ticks + 1
    if (1 - SKIP) * ticks < least:
        raise refusal(
            ("search", "ticks"),
            "is shorter than the measurements in [data]",
            ticks,
            f"at least {int(np.ceil(least / (1 - SKIP))):,}",
            source=config._source,
        )
    x = np.stack(list(outside.columns.values()), 1)
    kinds = tuple(config.data.statistics)
    observed = statistics(x, list(outside.columns), outside, kinds)
    if not observed:
        allowed = "lag (with at least two columns), amplitude, mean, or period with data.ticks"
        raise refusal(
            ("data", "statistics"), "leaves nothing to compare", list(kinds), allowed, source=config._source
        )
    words = [repr((outside.ticks, kinds, list(outside.columns))).encode(), outside.times.tobytes()]
    return Fit(outside, kinds, observed, hashlib.sha256(b"".join([*words, x.tobytes()])).hexdigest())


def sampled(series: Series, outside: Outside) -> np.ndarray | None:
    """Return the last part of a run with the length and sampling rate of the measurements (in periods, if the
    length of their time unit is unknown), f64[samples, columns], or None if there is none."""
    n = np.stack([numbers_of(series, name) for name in outside.columns], 1)
    n = n[int(SKIP * len(n)) :]
    if not (np.isfinite(n).all() and (n >= 0).all() and n.any(0).all()):
        return None
    samples = len(outside.times)
    if outside.ticks is not None:
        step = outside.step * outside.ticks
    else:
        step = period_of(*n.T) / cycle(*outside.columns.values()).period
    at = len(n) - 1 - np.floor(step * np.arange(samples)[::-1]).astype(int)
    return n[at] if at[0] >= 0 and n[at].any(0).all() else None


def statistics(x: np.ndarray, names: list[str], outside: Outside, kinds: tuple[str, ...]) -> Statistics:
    """Return the statistics of series f64[samples, names]: period of their shared cycle [log10 of time
    units], lags between them [periods], amplitudes [log10], means [log10]."""
    found = cycle(*x.T)
    out: Statistics = {}
    if "period" in kinds and outside.ticks is not None:
        out["period"] = float(np.log10(found.period * outside.step))
    if "lag" in kinds:
        out |= {
            f"lag {a}, {b}": float((found.phases[names.index(b)] - found.phases[names.index(a)]) % 1)
            for a, b in combinations(names, 2)
        }
    if "amplitude" in kinds:
        out |= {f"amplitude {name}": float(swing) for name, swing in zip(names, found.swings, strict=True)}
    if "mean" in kinds:
        out |= {f"mean {name}": float(np.log10(mean)) for name, mean in zip(names, x.mean(0), strict=True)}
    return out
