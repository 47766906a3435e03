"""Approximate Bayesian computation. abc draws candidates from the ranges and accepts those whose runs are most
similar to the measurements (Pritchard et al. 1999). abc-smc draws later generations around the nearest ones,
weighted by prior / proposal density (Beaumont et al. 2009, with the adaptive distances of Lenormand, Jabot &
Deffuant 2013). Proposals depend only on the seed and the journal. posterior.csv and search.json contain
the posterior."""

import csv
import io
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecs_eco.engine import files
from ecs_eco.lab.searching.journal import Journal
from ecs_eco.lab.searching.plan import Parameter, Plan

SAMPLERS = ("abc", "abc-smc")
FIRST_SEED = 200_000  # world seed of candidate 0
WIDE = 2.0  # covariance of steps / covariance of the nearest candidates
TRIED = 4000  # number of draws for estimating how many fall outside the ranges
FEWEST = 3  # minimum number of accepted candidates around which to draw
NAME = "posterior.csv"
ENDS = [0.05, 0.5, 0.95]  # quantiles given of the posterior


class Population(NamedTuple):
    """Accepted candidates, nearest first.

    Attributes
    ----------
    numbers : array of int64, shape (kept,)
        Numbers that identify the candidates.
    at : array of float64, shape (kept, parameters)
        Their positions in the unit cube of the ranges.
    weights : array of float64, shape (kept,)
        Importance weights.
    distances : array of float64, shape (kept,)
        Distances from the measurements.
    """

    numbers: np.ndarray  # i64[accepted], candidates
    at: np.ndarray  # f64[accepted, parameters], positions in the unit cube of the ranges
    weights: np.ndarray  # f64[accepted], prior density / proposal density
    distances: np.ndarray  # f64[accepted]

    @property
    def shares(self) -> np.ndarray:
        """The weights, normalized to a sum of 1."""
        return np.asarray(self.weights / self.weights.sum())


class Sampler:
    """Approximate Bayesian computation: proposes candidates and selects those that form the posterior.

    Parameters
    ----------
    plan : Plan
    kind : {"abc", "abc-smc"}
    journal : Journal
        Journal of the search.
    """

    def __init__(self, plan: Plan, kind: str, journal: Journal) -> None:
        assert plan.fit is not None
        self.plan, self.kind, self.journal, self.fit = plan, kind, journal, plan.fit
        settings = plan.config.search.posterior
        self.seed = plan.config.search.seed
        self.keep = settings.keep or (0.5 if kind == "abc-smc" else 0.1)
        self.particles, self.stop = settings.particles, settings.stop
        self.kept = max(FEWEST, round(self.keep * self.particles))
        self._after: dict[int, tuple[Population, float]] = {}  # results of complete generations

    def ask(self, number: int) -> dict[str, float]:
        rng = np.random.default_rng([self.seed, number])
        generation = self.generation(number)
        before = self._population(generation - 1) if generation > 0 else None
        place = rng.random(len(self.plan.parameters))
        if before is not None and len(before.numbers) >= FEWEST:
            root = np.linalg.cholesky(_spread(before))
            for _ in range(1000):
                centre = before.at[rng.choice(len(before.weights), p=before.shares)]
                near = centre + root @ rng.standard_normal(len(centre))
                if ((near >= 0) & (near <= 1)).all():
                    place = near
                    break
        return {p.name: p.tidy(value_at(p, u)) for p, u in zip(self.plan.parameters, place, strict=True)}

    def ready(self, number: int) -> bool:
        """Return whether the journal contains everything that a proposal depends on."""
        first = self._numbers(self.generation(number))[0]
        return first <= 1 or first - 1 <= len([e for e in self._entries() if e["candidate"] < first])

    def finished(self, number: int) -> bool:
        """Return whether the generation before this candidate's improved the posterior too little to continue."""
        generation = self.generation(number)
        if generation < 2 or number != self._numbers(generation)[0] or not self.ready(number):
            return False
        self._population(generation - 1)
        return self._after[generation - 1][1] < self.stop

    def tell(self, number: int, values: dict[str, float], worth: float) -> None:
        """Do nothing, because all state is in the journal."""

    def cell(self, number: int) -> tuple[int, int]:
        """Return the training seed and the world seed of a candidate; each candidate has its own world seed."""
        cells = self.plan.cells
        return cells[number % len(cells)][0], FIRST_SEED + number

    def posterior(self) -> Population:
        """Return the candidates kept so far.

        Returns
        -------
        Population
        """
        if self.kind == "abc":
            entries = self._entries()
            return _nearest(self._drawn(entries, None), max(1, round(self.keep * len(entries))))
        return self._population(self.generation(max((e["candidate"] for e in self._entries()), default=1)))

    def generation(self, number: int) -> int:
        """Return the generation of a candidate, from 0; candidate 0, the world as written, belongs to none."""
        if self.kind == "abc" or number <= self.particles:
            return 0
        return 1 + (number - 1 - self.particles) // (self.particles - self.kept)

    def _numbers(self, generation: int) -> range:
        if generation == 0:
            return range(1, self.particles + 1)
        first, each = 1 + self.particles, self.particles - self.kept
        return range(first + (generation - 1) * each, first + generation * each)

    def _entries(self) -> list[dict[str, Any]]:
        return sorted(
            (e for e in self.journal.of("candidate") if e["candidate"]), key=lambda e: int(e["candidate"])
        )

    def _population(self, generation: int) -> Population:
        """Return the candidates accepted after a generation, among those in the journal."""
        if generation in self._after:
            return self._after[generation][0]
        numbers = self._numbers(generation)
        entries = [e for e in self._entries() if e["candidate"] in numbers]
        before = None if generation == 0 else self._population(generation - 1)
        new = self._drawn(entries, before)
        both = new if before is None else Population(*map(np.concatenate, zip(before, new, strict=True)))
        kept = _nearest(both, self.kept)
        if len(entries) == len(numbers):
            self._after[generation] = kept, float(np.isin(kept.numbers, new.numbers).sum() / len(numbers))
        return kept

    def _drawn(self, entries: list[dict[str, Any]], before: Population | None) -> Population:
        """Return the candidates of one generation that could be compared, with importance weights."""
        there = [(e, own) for e in entries if (own := statistics_of(e)) is not None]
        at = np.array([[place_of(p, e["values"][p.name]) for p in self.plan.parameters] for e, _ in there])
        at = at.reshape(len(there), len(self.plan.parameters))
        apart = np.array([self.fit.differences(own) for _, own in there])
        apart = apart.reshape(len(there), len(self.fit.observed)) / self.scales()
        weights = np.ones(len(there))
        if before is not None and len(before.numbers) >= FEWEST and len(there):
            weights = 1 / _density(at, before)
        return Population(
            np.array([e["candidate"] for e, _ in there], dtype=np.int64),
            at,
            weights,
            np.sqrt((apart**2).mean(1)) if len(there) else np.zeros(0),
        )

    def scales(self) -> np.ndarray:
        """Return each statistic's scale: its median absolute deviation over candidates from the ranges."""
        first = [e for e in self._entries() if self.kind == "abc" or e["candidate"] <= self.particles]
        apart = np.array([self.fit.differences(own) for e in first if (own := statistics_of(e)) is not None])
        if len(apart) < FEWEST:
            return np.full(len(self.fit.observed), 0.1)
        scale = 1.4826 * np.median(np.abs(apart - np.median(apart, 0)), 0)
        return np.where(scale > 1e-9, scale, 1.0)


def statistics_of(entry: dict[str, Any]) -> dict[str, float] | None:
    """Return the statistics of a candidate's run, or None if it was rejected or a species died out."""
    runs = entry["stages"][-1]["runs"] if entry["stages"] else []
    return runs[-1].get("statistics") if runs else None


def value_at(p: Parameter, u: float) -> float:
    """Return the value at a fraction of a parameter's range."""
    if p.log:
        return float(p.low * (p.high / p.low) ** u)
    return p.low + u * (p.high - p.low)


def place_of(p: Parameter, value: float) -> float:
    """Return a parameter value's position as a fraction of the range."""
    if p.log:
        return float(np.log(value / p.low) / np.log(p.high / p.low))
    return (value - p.low) / (p.high - p.low)


def weighted_quantiles(x: np.ndarray, weights: np.ndarray, q: list[float]) -> np.ndarray:
    """Return quantiles of the distribution from which weighted numbers were drawn.

    Parameters
    ----------
    x : array of float, shape (n,)
    weights : array of float, shape (n,)
    q : list of float
        Probabilities, 0 to 1.

    Returns
    -------
    array of float64, shape (len(q),)

    Notes
    -----
    The i-th of n numbers with equal weight is the i / (n + 1) quantile (Weibull 1939), so that a 90% interval
    contains the next number in nine of ten cases.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.lab.searching.sampler import weighted_quantiles
    >>> weighted_quantiles(np.array([1.0, 2.0, 3.0]), np.ones(3), [0.25, 0.5]).tolist()
    [1.0, 2.0]
    """
    order = np.argsort(x, kind="stable")
    w = weights[order] / weights.sum()
    n = 1 / (w**2).sum()
    return np.interp(q, (n * (np.cumsum(w) - w / 2) + 0.5) / (n + 1), x[order])


def _nearest(of: Population, n: int) -> Population:
    order = np.lexsort((of.numbers, of.distances))[:n]
    return Population(*(column[order] for column in of))


def _spread(of: Population) -> np.ndarray:
    """Return the covariance of the steps from a member of a population to a new candidate."""
    centred = of.at - of.shares @ of.at
    return np.asarray(WIDE * (centred * of.shares[:, None]).T @ centred + 1e-6 * np.eye(of.at.shape[1]))


def _density(at: np.ndarray, of: Population) -> np.ndarray:
    """Return the density of proposals around a population at positions f64[n, parameters], relative to the
    prior. Proposals outside the ranges are drawn again; draws estimate their fraction."""
    root = np.linalg.cholesky(_spread(of))
    steps = np.linalg.solve(root, (at[:, None] - of.at[None]).reshape(-1, at.shape[1]).T)
    exponent = -0.5 * (steps**2).sum(0).reshape(len(at), len(of.at))
    scale = np.sqrt((2 * np.pi) ** at.shape[1]) * np.prod(np.diag(root))
    rng = np.random.default_rng(0)
    tried = of.at[rng.choice(len(of.at), TRIED, p=of.shares)]
    tried = tried + rng.standard_normal(tried.shape) @ root.T
    inside = max(1, ((tried >= 0) & (tried <= 1)).all(1).sum()) / TRIED
    return np.asarray(np.exp(exponent) @ of.shares / scale / inside)


def write_posterior(sampler: Sampler, out: Path) -> dict[str, Any]:
    """Write posterior.csv, with a row for each accepted candidate, nearest first: candidate, generation,
    weight (summing to 1), distance, parameter values by dotted key, statistics; return its search.json entry."""
    kept = sampler.posterior()
    entries = {e["candidate"]: e for e in sampler.journal.of("candidate")}
    names, measured = [p.name for p in sampler.plan.parameters], list(sampler.fit.observed)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["candidate", "generation", "weight", "distance", *names, *measured])
    columns = (kept.numbers.tolist(), kept.shares.tolist(), kept.distances.tolist())
    for candidate, weight, distance in zip(*columns, strict=True):
        own = statistics_of(entries[candidate]) or {}
        values = entries[candidate]["values"]
        table.writerow(
            [
                candidate,
                sampler.generation(candidate),
                repr(weight),
                repr(distance),
                *(repr(values[name]) for name in names),
                *(repr(own[name]) for name in measured),
            ]
        )
    files.write(out / NAME, text.getvalue())
    return summary(sampler, kept, entries)


def summary(sampler: Sampler, kept: Population, entries: dict[int, dict[str, Any]]) -> dict[str, Any]:
    """Return the posterior's entry in search.json: means and central 90% intervals."""
    out: dict[str, Any] = {
        "candidates": sum(number > 0 for number in entries),
        "compared": sum(number > 0 and statistics_of(e) is not None for number, e in entries.items()),
        "kept": len(kept.numbers),
        "observed": sampler.fit.observed,
        "generations": 1 + max(map(sampler.generation, entries)),
        "furthest": float(kept.distances.max()) if len(kept.distances) else None,
        "effective": float(1 / (kept.shares**2).sum()) if len(kept.numbers) else 0.0,
        "numbers": {},
        "statistics": {},
    }
    if not len(kept.numbers):
        return out
    for k, p in enumerate(sampler.plan.parameters):
        low, middle, high = weighted_quantiles(kept.at[:, k], kept.shares, ENDS)
        out["numbers"][p.name] = {
            "range": [p.low, p.high],
            "mean": float(kept.shares @ np.array([value_at(p, u) for u in kept.at[:, k]])),
            "low": value_at(p, low),
            "median": value_at(p, middle),
            "high": value_at(p, high),
        }
    apart = np.array(
        [sampler.fit.differences(statistics_of(entries[n]) or {}) for n in kept.numbers.tolist()]
    )
    for k, (name, observed) in enumerate(sampler.fit.observed.items()):
        low, middle, high = observed + weighted_quantiles(apart[:, k], kept.shares, ENDS)
        out["statistics"][name] = {
            "observed": observed,
            "low": float(low),
            "median": float(middle),
            "high": float(high),
        }
    return out
