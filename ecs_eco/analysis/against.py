"""Compare the periods, amplitudes and lags of a run with those of an outside series, all by `signature.cycle`.
There is no test, because field counts are often too short for those in `ecs_eco.analysis.spectrum`."""

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ecs_eco.analysis.runs import Series, mean_of_there
from ecs_eco.analysis.signature import cycle
from ecs_eco.analysis.spectrum import thin
from ecs_eco.config.measurements import FEWEST, MOST_ROWS, Outside
from ecs_eco.engine.errors import ConfigError, Problem


class Summary(NamedTuple):
    """Summary statistics of one series."""

    samples: int
    period: float  # period of the wave that explains the most variance [time unit of the series]
    cycles: float  # number of periods in the series
    share: float  # fraction of the variance that this wave explains
    amplitude: float  # standard deviation of log10 values after removing the trend


class Both(NamedTuple):
    """Summaries of each series in the run [ticks] and in the outside data, and the lags between them."""

    run: dict[str, Summary]
    outside: dict[str, Summary]
    lags: dict[tuple[str, str], tuple[float, float]]  # lag of b behind a in periods, as (run, outside)


def numbers_of(series: Series, name: str) -> np.ndarray:
    """Return the population sizes of a species, or a reporter's values averaged over species: f64[ticks]."""
    if name in series.species:
        return series.of(name)
    return mean_of_there(series.columns[name], axis=1)


def compare(series: Series, outside: Outside, skip: float = 0.1) -> Both:
    """Describe the outside series and the `living` part of the run; raise ConfigError if that is too short."""
    names = list(outside.columns)
    n = living(series, names, skip)
    thinned, factor = thin(n.T, MOST_ROWS)
    ours = dict(zip(names, thinned, strict=True))
    lags = {}
    for a, b in combinations(names, 2):
        both = cycle(ours[a], ours[b]), cycle(outside.columns[a], outside.columns[b])
        lags[a, b] = float(both[0].phases[1]), float(both[1].phases[1])
    run = {name: summary(x, factor)._replace(samples=len(n)) for name, x in ours.items()}
    return Both(run, {name: summary(x, outside.step) for name, x in outside.columns.items()}, lags)


def living(series: Series, names: Sequence[str], skip: float = 0.1) -> np.ndarray:
    """Return values before the first extinction, without the first `skip` of the run: f64[ticks, names]. Raises
    ConfigError if too few ticks remain."""
    n = np.stack([numbers_of(series, name) for name in names], 1)
    species = [name in series.species for name in names]
    gone = np.flatnonzero((n[:, species] == 0).any(1))
    end = int(gone[0]) if gone.size else len(n)
    n = n[min(int(skip * len(n)), end) : end]
    usable = np.isfinite(n).all(0) & (n >= 0).all(0) & n.any(0)
    wrong = [name for name, fine in zip(names, usable, strict=True) if not fine]
    if len(n) >= FEWEST and wrong:
        fault = "is negative or not a number in some ticks, or always 0"
        raise ConfigError([Problem((), fault, wrong[0], "a reporter of counts or densities", source="DIR")])
    if len(n) < FEWEST:
        fault = f"{len(n)} ticks remain before the first extinction"
        raise ConfigError([Problem((), fault, "", "a run in which all species persist", source="DIR")])
    return n


def summary(x: np.ndarray, step: float) -> Summary:
    """Describe one series whose samples are `step` apart. Raises the same errors as `signature.logarithms`."""
    found = cycle(x)
    return Summary(
        len(x), found.period * step, len(x) / found.period, float(found.shares[0]), float(found.swings[0])
    )
