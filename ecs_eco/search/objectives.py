"""The score of a run: the share of its time in which all species lived;
plus the objective if they lived to the end.

Late extinction is thus better than early extinction, and any world without extinction better than one with,
for objectives of 0 or more.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ecs_eco.analysis.runs import Series
from ecs_eco.config.models.search import OBJECTIVES, Search
from ecs_eco.engine.code import handed_over
from ecs_eco.search.fit import Fit


def objective(
    search: Search,
    series: Series,
    persist: Sequence[str],
    find: Callable[[Any], Any] = handed_over,
    fit: Fit | None = None,
) -> float:
    """The weighted mean of a search's goals for a run in which all lived; `find` gives "module:name", `fit`
    is what the goal data compares with."""
    goals = [
        (of if of in OBJECTIVES or of in series.reporters else find(of), weight)
        for of, weight in search.goals
    ]
    return float(
        sum(
            weight
            * (
                likeness(series, fit)
                if of == "data" and fit is not None
                else score(of, series, persist, search.wanted)
            )
            for of, weight in goals
        )
    )


def likeness(series: Series, fit: Fit) -> float:
    """1 / (1 + the mean difference of statistics from the measured ones [tenths]); 0 where the run is too
    short to have them."""
    own = fit.of(series)
    if own is None:
        return 0.0
    return float(1 / (1 + 10 * np.sqrt(np.mean(fit.differences(own) ** 2))))


def score(
    of: str | Callable[[Series], float], series: Series, persist: Sequence[str], wanted: Mapping[str, float]
) -> float:
    """One goal's score of a run; that of a user's function or reporter is clipped to ±1e6, and NaN counts as
    0."""
    if of == "persistence":
        return distance(series, persist)
    if of == "cycling":
        return cycling(series, persist)
    if of == "population":
        return population(series, {name: n for name, n in wanted.items() if name in series.species})
    if isinstance(of, str) and of in series.reporters:
        return _clipped(reported(series, of, wanted.get(of)))
    return _clipped(float(handed_over(of)(series)))


def _clipped(value: float) -> float:
    return float(np.clip(value, -1e6, 1e6)) if np.isfinite(value) else 0.0


def distance(series: Series, persist: Sequence[str]) -> float:
    """Distance from extinction: ln(1 + least n) / ln(1 + mean n) of the species closest to it, in [0, 1]."""
    distances = [np.log1p(n.min()) / np.log1p(n.mean()) for s in persist if (n := series.of(s)).any()]
    return float(min(distances, default=0.0))


def cycling(series: Series, persist: Sequence[str]) -> float:
    """Mean over species of ln(p) / ln(.05), at most 1, of the spectral peak against AR(1) noise."""
    from ecs_eco.analysis.cycles import cycle_statistics

    statistics = cycle_statistics(series, n_boot=199)
    p = [statistics.p_ar1.get(s) or 1.0 for s in persist]
    return float(np.mean(np.minimum(1.0, np.log(p) / np.log(0.05))))


def population(series: Series, wanted: Mapping[str, float]) -> float:
    """Mean over species of n / wanted or wanted / n, whichever is less; n is the later half's mean number."""
    half = len(series.ticks) // 2
    n = np.array([series.of(s)[half:].mean() for s in wanted])
    w = np.array(list(wanted.values()))
    return float(np.mean(np.minimum(n / w, w / np.maximum(n, 1e-9))))


def reported(series: Series, name: str, wanted: float | None) -> float:
    """Mean of a reporter over the later half of a run, and over species; or, if one is wanted, how near it
    is: the ratio of both, at most 1, and 0 where the mean is not above 0."""
    values = series.columns[name][len(series.ticks) // 2 :]
    mean = float(values[np.isfinite(values)].mean()) if np.isfinite(values).any() else float("nan")
    if wanted is None:
        return mean
    return max(0.0, min(mean / wanted, wanted / mean if mean > 0 else 0.0))
