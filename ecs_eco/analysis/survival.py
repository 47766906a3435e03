"""Survival and persistence: curves, tests and intervals that treat extinction as an outcome."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecs_eco.analysis import quantiles

if TYPE_CHECKING:
    from scipy.stats import CensoredData
    from scipy.stats._survival import EmpiricalDistributionFunction

Numbers = Sequence[float] | np.ndarray
Flags = Sequence[bool] | np.ndarray


class Interval(NamedTuple):
    """An estimate with its interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class SurvivalCurve:
    """Kaplan–Meier estimate from time 0; `survival[i]` applies from `time[i]` to the next time.

    Examples
    --------
    >>> from ecs_eco.analysis.survival import kaplan_meier
    >>> curve = kaplan_meier([2.0, 4.0], [True, True])
    >>> curve.median, curve.mean(until=3.0)
    (2.0, 2.5)
    """

    time: np.ndarray
    at_risk: np.ndarray
    died: np.ndarray
    survival: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @property
    def median(self) -> float:
        """First time at which at most half survive; NaN if more than half survive to the end of observation."""
        below = np.flatnonzero(self.survival <= 0.5 + 1e-12)
        return float(self.time[below[0]]) if len(below) else np.nan

    def mean(self, until: float) -> float:
        """Return the restricted mean survival time: the area under the curve up to `until`.

        Parameters
        ----------
        until : float
            Upper time limit of the area.

        Returns
        -------
        float
        """
        edges = np.append(np.minimum(self.time, until), until)
        return float((np.diff(edges) * self.survival).sum())


def kaplan_meier(durations: Numbers, died: Flags, level: float = 0.95) -> SurvivalCurve:
    """Return the Kaplan–Meier estimate of survival.

    Parameters
    ----------
    durations : sequence of float
        Time until death or the end of observation.
    died : sequence of bool
        False where observation ended before death (censored).
    level : float, default 0.95
        Confidence level.

    Returns
    -------
    SurvivalCurve

    Notes
    -----
    The interval uses Greenwood's variance on the log(−log) scale (Kalbfleisch and Prentice 1980). Where it is
    undefined (survival is 1 or 0), it is [1, 1] before the first death and [0, last upper limit] after the
    last.

    Examples
    --------
    >>> from ecs_eco.analysis.survival import kaplan_meier
    >>> curve = kaplan_meier([2.0, 3.0, 3.0, 5.0], [True, True, False, True])
    >>> curve.survival.tolist()
    [1.0, 0.75, 0.5, 0.0]
    """
    t, d = np.asarray(durations, float), np.asarray(died, bool)
    estimate = survival_function(t, d)
    time = np.unique(np.append(t[d], 0.0))
    survival = estimate.evaluate(time)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # undefined at 0 and 1: filled in below
        interval = estimate.confidence_interval(level, method="log-log")
    low, high = interval.low.evaluate(time), interval.high.evaluate(time)
    low, high = np.where(survival == 1, 1.0, low), np.where(survival == 1, 1.0, high)
    if survival[-1] == 0:
        low[-1], high[-1] = 0.0, high[-2] if len(time) > 1 else 1.0
    at_risk = len(t) - np.searchsorted(np.sort(t), time)
    deaths = np.bincount(np.searchsorted(time, t[d]), minlength=len(time))
    return SurvivalCurve(time, at_risk, deaths, survival, low, high)


def survival_function(durations: Numbers, died: Flags) -> EmpiricalDistributionFunction:
    """Return the Kaplan–Meier estimate as a function of time; raise ValueError if durations are invalid."""
    t, d = np.asarray(durations, float), np.asarray(died, bool)
    if t.shape != d.shape or t.ndim != 1:
        expected = "durations and died must be one-dimensional and equally long"
        raise ValueError(f"{expected}, got shapes {t.shape} and {d.shape}")
    if (t < 0).any() or np.isnan(t).any():
        raise ValueError(f"durations must be 0 or more, got {t[(t < 0) | np.isnan(t)][0]}")
    from scipy.stats import ecdf  # takes a second to import

    return ecdf(_censored(t, d)).sf


def log_rank(one: tuple[Numbers, Flags], other: tuple[Numbers, Flags]) -> tuple[float, float]:
    """Return the log-rank test between two groups (Mantel 1966).

    Parameters
    ----------
    one, other : tuple of (durations, died)
        The two groups, as in `kaplan_meier`.

    Returns
    -------
    chi2 : float
        Statistic with one degree of freedom.
    p : float

    Examples
    --------
    >>> from ecs_eco.analysis.survival import log_rank
    >>> chi2, p = log_rank(([1, 2, 3, 4], [True] * 4), ([5, 6, 7, 8], [True] * 4))
    >>> p < 0.05
    True
    """
    if not np.any(one[1]) and not np.any(other[1]):
        return 0.0, 1.0
    from scipy.stats import logrank

    with np.errstate(invalid="ignore"):
        test = logrank(_censored(*one), _censored(*other))
    if np.isnan(test.statistic):  # no deaths while both groups were observed
        return 0.0, 1.0
    return float(test.statistic**2), float(test.pvalue)


def _censored(durations: Numbers, died: Flags) -> CensoredData:
    from scipy.stats import CensoredData

    t, d = np.asarray(durations, float), np.asarray(died, bool)
    return CensoredData(uncensored=t[d], right=t[~d])


def wilson(successes: float, n: float, level: float = 0.95) -> Interval:
    """Return a share with Wilson's score interval (Wilson 1927).

    Parameters
    ----------
    successes : float
    n : float
        Number of trials; an effective number need not be an integer.
    level : float, default 0.95

    Returns
    -------
    Interval
        The share and its interval, which is [0, 1] if n is 0.

    Raises
    ------
    ValueError
        If `successes` is not between 0 and n.

    Examples
    --------
    >>> from ecs_eco.analysis.survival import wilson
    >>> share = wilson(7, 8)
    >>> round(share.low, 2), round(share.high, 2)
    (0.53, 0.98)
    """
    if not 0 <= successes <= n:
        raise ValueError(f"successes = {successes}; expected 0 to {n}")
    if n == 0:
        return Interval(np.nan, 0.0, 1.0)
    z2, share = quantiles.normal(level) ** 2, successes / n
    centre = (share + z2 / (2 * n)) / (1 + z2 / n)
    half = np.sqrt(z2 * (share * (1 - share) / n + z2 / (4 * n * n))) / (1 + z2 / n)
    return Interval(share, float(max(0.0, centre - half)), float(min(1.0, centre + half)))


def difference_of_shares(k1: int, n1: int, k2: int, n2: int, level: float = 0.95) -> Interval:
    """Return the difference between two shares with Newcombe's hybrid interval (Newcombe 1998, method 10).

    Parameters
    ----------
    k1, k2 : int
        Successes.
    n1, n2 : int
        Trials.
    level : float, default 0.95

    Returns
    -------
    Interval

    Examples
    --------
    >>> from ecs_eco.analysis.survival import difference_of_shares
    >>> difference_of_shares(8, 8, 2, 8).value
    0.75
    """
    return difference_of_intervals(wilson(k1, n1, level), wilson(k2, n2, level))


def difference_of_intervals(a: Interval, b: Interval) -> Interval:
    """Return a − b for independent estimates by adding squared distances to the ends (Zou and Donner 2008)."""
    gap, down = a.value - b.value, float(np.hypot(a.value - a.low, b.high - b.value))
    return Interval(gap, gap - down, gap + float(np.hypot(a.high - a.value, b.value - b.low)))


def bootstrap_difference(
    a: Sequence[float],
    b: Sequence[float],
    *,
    paired: bool = False,
    statistic: Callable[..., np.ndarray] = np.mean,
    n_boot: int = 9999,
    level: float = 0.95,
    seed: int = 0,
) -> Interval:
    """Return statistic(a) − statistic(b) with a bootstrap interval over seeds or, if `paired`, the statistic
    of the pairwise differences a − b.

    Parameters
    ----------
    a, b : sequence of float
        One number per seed in each group.
    paired : bool, default False
        Use the differences a − b of pairs, which must be equally many.
    statistic : callable, default numpy.mean
        Function of an array that accepts `axis`.
    n_boot : int, default 9999
        Number of bootstrap samples.
    level : float, default 0.95
    seed : int, default 0
        Random seed for the bootstrap.

    Returns
    -------
    Interval
        Its ends are NaN if a group has fewer than 2 members.

    Raises
    ------
    ValueError
        If paired samples differ in length.

    Notes
    -----
    A percentile interval is too narrow if there are few seeds; this one is expanded by √(n/(n−1)) and by the ratio
    of Student's t to normal quantiles, with Welch's degrees of freedom (Hesterberg 2015).

    Examples
    --------
    >>> from ecs_eco.analysis.survival import bootstrap_difference
    >>> gap = bootstrap_difference([5.0, 6.0, 7.0], [1.0, 2.0, 3.0], n_boot=99)
    >>> gap.value, gap.low > 0
    (4.0, True)
    """
    x, y = np.asarray(a, float), np.asarray(b, float)
    if paired and x.shape != y.shape:
        raise ValueError(f"paired samples must be equally long, got {len(x)} and {len(y)}")
    samples = [x - y] if paired else [x, -y]
    if min(map(len, samples)) < 1:
        return Interval(np.nan, np.nan, np.nan)
    value = float(sum(statistic(v, axis=0) for v in samples))
    if min(map(len, samples)) < 2:
        return Interval(value, np.nan, np.nan)
    rng = np.random.default_rng(seed)
    off, variance, scale = np.zeros(n_boot), 0.0, 0.0
    for v in samples:
        drawn = statistic(v[rng.integers(0, len(v), (n_boot, len(v)))], axis=1) - statistic(v, axis=0)
        drawn = drawn * np.sqrt(len(v) / (len(v) - 1))
        off += drawn
        variance += drawn.var()
        scale += drawn.var() ** 2 / (len(v) - 1)
    if not variance:
        return Interval(value, value, value)
    expand = quantiles.student(variance**2 / scale, level) / quantiles.normal(level)
    low, high = np.quantile(off, [0.5 - level / 2, 0.5 + level / 2]) * expand
    return Interval(value, value + float(low), value + float(high))
