"""Is a gene selected? Estimates and tests for gene frequencies over time, pooled over runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.stats import chi2, t

if TYPE_CHECKING:
    from ecs_eco.analysis.lineage import Lineage

Numbers = Sequence[float] | np.ndarray


class Pooled(NamedTuple):
    """A mean over runs with Student's t intervals, whose bounds are NaN for fewer than 2 runs."""

    n: int
    mean: float
    interval95: tuple[float, float]
    interval90: tuple[float, float]


class Equivalence(NamedTuple):
    """Two one-sided tests: `equivalent` if both reject at `alpha`; `p` is the larger p-value."""

    n: int
    mean: float
    interval: tuple[float, float]
    margin: float
    p: float
    equivalent: bool


class IncrementTest(NamedTuple):
    """Frequency increment test on n increments: t statistic and two-sided p."""

    n: int
    t: float
    p: float


class AgeRates(NamedTuple):
    """Deaths from a cause per organism per second, by age class from edges[i] (exclusive) to edges[i + 1]
    [s], with exact intervals."""

    edges: np.ndarray
    deaths: np.ndarray
    lived: np.ndarray
    rate: np.ndarray
    low: np.ndarray
    high: np.ndarray


def selection_coefficient(
    carriers: Numbers, reference: Numbers, n: Numbers, generation: Numbers, pseudo: float = 0.5
) -> float:
    """Return a gene's selection coefficient per generation against a neutral reference.

    It is the least-squares slope over `generation` [samples] of logit(p_gene) − logit(p_reference), where p
    is computed from the counts `carriers` and `reference` among `n` living organisms, with `pseudo` added to
    the numbers of carriers and non-carriers. A gene with relative fitness 1 + s gains ln(1 + s) in logit(p)
    per generation (Crow and Kimura 1970, chapter 5) if reproduction is asexual or genes are inherited
    independently. Samples without living organisms are omitted; the result is NaN for fewer than two distinct
    generations.
    """
    k, r, n, x = (np.asarray(v, float) for v in (carriers, reference, n, generation))
    _same(carriers=k, reference=r, n=n, generation=x)
    if ((k < 0) | (r < 0) | (k > n) | (r > n)).any():
        raise ValueError("selection_coefficient: carriers and reference must be counts from 0 to n")
    there = (n > 0) & np.isfinite(x)
    k, r, n, x = k[there], r[there], n[there], x[there]
    if len(np.unique(x)) < 2:
        return np.nan
    y = np.log((k + pseudo) / (n - k + pseudo)) - np.log((r + pseudo) / (n - r + pseudo))
    x = x - x.mean()
    return float((x @ y) / (x @ x))


def path_coefficient(
    carriers: Numbers, n: Numbers, generation: Numbers, mutation: float = 0.0, share: float = 0.25
) -> float:
    """Return a gene's selection coefficient per generation, estimated from the likelihood of its path.

    It is sum (dp − m (q − p) dt) / sum p (1 − p) dt over samples, where m is the mutation rate per letter and
    q is the share of mutated letters that become the gene. In the diffusion limit of the Wright–Fisher model,
    where dp = (s p (1 − p) + m (q − p)) dt + noise of variance p (1 − p) dt / N (Crow and Kimura 1970,
    chapter 8), this s maximizes the likelihood for any constant N. Each sample has weight p (1 − p), so a
    lost or fixed gene adds no information and the estimate does not depend on how long the run continues
    afterwards. The result is NaN if the gene has no variance. Samples without living organisms are omitted.
    """
    k, n, x = (np.asarray(v, float) for v in (carriers, n, generation))
    _same(carriers=k, n=n, generation=x)
    if ((k < 0) | (k > n)).any():
        raise ValueError("path_coefficient: carriers must be counts from 0 to n")
    there = (n > 0) & np.isfinite(x)
    p, x = k[there] / n[there], x[there]
    dt, dp, before = np.diff(x), np.diff(p), p[:-1]
    weight = (before * (1 - before) * dt).sum()
    return float((dp - mutation * (share - before) * dt).sum() / weight) if weight > 0 else np.nan


def pooled(values: Numbers) -> Pooled:
    """Return the mean of one number per run, with 95% and 90% intervals (Student's t)."""
    v = _finite("pooled", values)
    return Pooled(len(v), float(v.mean()), _interval(v, 0.95), _interval(v, 0.90))


def mean_interval(values: list[float]) -> list[float]:
    """Return a mean and its 95% interval (t): [mean, low, high]; NaN for fewer than two values."""
    if len(values) < 2:
        return [float(np.mean(values)) if values else float("nan"), float("nan"), float("nan")]
    estimate = pooled(values)
    return [estimate.mean, *estimate.interval95]


def equivalence(values: Numbers, margin: float, alpha: float = 0.05) -> Equivalence:
    """Test that the mean over runs lies within ± margin: two one-sided t tests (Schuirmann 1987).

    The interval has level 1 − 2 alpha: it lies within the margin if and only if the tests find equivalence.
    """
    if not margin > 0:
        raise ValueError(f"equivalence: the margin is {margin}; expected above 0")
    v = _finite("equivalence", values)
    n, mean = len(v), float(v.mean())
    if n < 2:
        return Equivalence(n, mean, (np.nan, np.nan), margin, np.nan, False)
    error = v.std(ddof=1) / np.sqrt(n)
    near = margin - abs(mean)
    p = float(t.sf(near / error, n - 1)) if error else float(near <= 0)
    return Equivalence(n, mean, _interval(v, 1 - 2 * alpha), margin, p, p < alpha)


def increments(share: Numbers, generation: Numbers) -> np.ndarray:
    """Return the rescaled frequency increments of Feder, Kryazhimskiy and Plotkin (2014): f64[increments].

    They are (v_i − v_{i−1}) / √(2 v_{i−1} (1 − v_{i−1}) (t_i − t_{i−1})), excluding increments that begin or
    end at a share of 0 or 1.
    """
    v, x = np.asarray(share, float), np.asarray(generation, float)
    _same(share=v, generation=x)
    if ((v < 0) | (v > 1)).any():
        raise ValueError(f"increments: expected shares from 0 to 1, got {v[(v < 0) | (v > 1)][0]}")
    inside = (v > 0) & (v < 1) & np.isfinite(x)
    both = inside[1:] & inside[:-1]
    step = np.diff(x)[both]
    if (step <= 0).any():
        raise ValueError("increments: generations must ascend from sample to sample")
    before = v[:-1][both]
    return np.diff(v)[both] / np.sqrt(2 * before * (1 - before) * step)


def frequency_increment_test(share: Numbers, generation: Numbers) -> IncrementTest:
    """Test whether the mean frequency increment differs from 0 (Feder, Kryazhimskiy and Plotkin 2014).

    t = mean / √(S² / n) of the n rescaled increments, with n − 1 degrees of freedom. The test assumes
    constant population size, precisely known shares, and small increments. The result is NaN for fewer than 2
    increments.
    """
    y = increments(share, generation)
    if len(y) < 2 or not y.std():
        return IncrementTest(len(y), np.nan, np.nan)
    value = float(y.mean() / np.sqrt(y.var(ddof=1) / len(y)))
    return IncrementTest(len(y), value, float(2 * t.sf(abs(value), len(y) - 1)))


def reappearances(carriers: Numbers) -> int:
    """Return how often a gene reappears after having no carriers."""
    k = np.asarray(carriers)
    seen = np.cumsum(k > 0) > 0
    return int(((k[1:] > 0) & (k[:-1] == 0) & seen[:-1]).sum())


def deaths_by_age(
    lineage: Lineage, cause: str | None, edges: Numbers, species: str | None = None, level: float = 0.95
) -> AgeRates:
    """Return deaths from a cause (None: any cause) per organism per second of life, by age class [s].

    Each organism contributes time to every age class that it lived through; organisms alive at the end are
    censored. An organism that dies at the edge between two classes counts in the younger one. Intervals are
    exact for a Poisson count (Garwood 1936); rates are NaN for classes that no organism reached.
    """
    edges = np.asarray(edges, float)
    if len(edges) < 2 or (np.diff(edges) <= 0).any():
        raise ValueError(f"deaths_by_age: expected at least 2 edges in ascending order, got {edges.tolist()}")
    who = np.ones(len(lineage), bool) if species is None else lineage.species == species
    dead = lineage.died[who] >= 0
    age = (np.where(dead, lineage.died[who], lineage.end) - lineage.born[who]) * lineage.dt
    dead &= True if cause is None else lineage.cause[who] == cause
    # organisms that die at birth count in the first class
    at = np.searchsorted(edges, np.maximum(age[dead], 1e-9)) - 1
    deaths = np.bincount(at[(at >= 0) & (at < len(edges) - 1)], minlength=len(edges) - 1)
    lived = np.array([(np.clip(age, a, b) - a).sum() for a, b in zip(edges, edges[1:], strict=False)])
    low, high = poisson_interval(deaths, level)
    span = np.where(lived > 0, lived, np.nan)
    return AgeRates(edges, deaths, lived, deaths / span, low / span, high / span)


def poisson_interval(count: np.ndarray, level: float = 0.95) -> tuple[np.ndarray, np.ndarray]:
    """Return the exact interval for the mean of a Poisson count (Garwood 1936)."""
    k = np.asarray(count, float)
    low = np.where(k > 0, chi2.ppf((1 - level) / 2, np.maximum(2 * k, 1)) / 2, 0.0)
    return low, chi2.ppf((1 + level) / 2, 2 * k + 2) / 2


def _interval(v: np.ndarray, level: float) -> tuple[float, float]:
    if len(v) < 2:
        return np.nan, np.nan
    half = float(t.ppf(0.5 + level / 2, len(v) - 1) * v.std(ddof=1) / np.sqrt(len(v)))
    return float(v.mean()) - half, float(v.mean()) + half


def _finite(what: str, values: Numbers) -> np.ndarray:
    v = np.asarray(values, float)
    if v.ndim != 1 or not len(v) or not np.isfinite(v).all():
        raise ValueError(f"{what}: expected one finite number per run, got {v.tolist()}")
    return v


def _same(**arrays: Any) -> None:
    shapes = {name: a.shape for name, a in arrays.items()}
    if len(set(shapes.values())) != 1 or len(next(iter(shapes.values()))) != 1:
        raise ValueError(
            "expected one-dimensional samples of equal length, got "
            f"{', '.join(f'{n} {s}' for n, s in shapes.items())}"
        )
