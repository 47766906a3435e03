"""What mattered: a Gaussian process through all candidates, how much of its variance each number explains, and with what uncertainty.

Its variance over the ranges is split as Sobol' (2001) does; the split is done for draws from the posterior, and their spread is
how much the candidates leave open (Marrel et al. 2009).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky
from scipy.optimize import minimize
from scipy.stats import qmc, rankdata

from ecs_eco.search.plan import Parameter

MOST = 400  # candidates that the process goes through
BASE, DRAWS = 128, 100


@dataclass(frozen=True)
class Process:
    """A Gaussian process over the unit cube, with squared exponential covariance and a length for each number."""

    x: np.ndarray  # (n, d)
    mean: float
    lengths: np.ndarray  # (d,)
    signal: float  # variance
    noise: float  # variance
    weights: np.ndarray  # (n,)
    factor: tuple[np.ndarray, bool]
    explained: float  # 1 − squared error over variance, each candidate foretold from the others

    def foretell(self, points: np.ndarray) -> np.ndarray:
        """Mean at points (k, d)."""
        return self.mean + self.covariance(points, self.x) @ self.weights

    def spread(self, points: np.ndarray) -> np.ndarray:
        """Posterior covariance of points (k, d): (k, k)."""
        cross = self.covariance(points, self.x)
        return self.covariance(points, points) - cross @ cho_solve(self.factor, cross.T)

    def covariance(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Prior covariance of two sets of points."""
        return _kernel(a, b, self.lengths, self.signal)


@dataclass(frozen=True)
class Matter:
    """Shares of variance that a number explains alone (`first`) and with all others (`total`): median, low and high (90 %)."""

    name: str
    first: tuple[float, float, float]
    total: tuple[float, float, float]


def unit(parameters: Sequence[Parameter], values: Sequence[dict[str, float]]) -> np.ndarray:
    """Candidates as points of the unit cube: (n, d)."""
    return np.array([[_share(p, v[p.name]) for p in parameters] for v in values]).reshape(len(values), len(parameters))


def _share(p: Parameter, value: float) -> float:
    low, high, value = (np.log([p.low, p.high, value]) if p.log else (p.low, p.high, value))
    return float((value - low) / (high - low))


def value_of(p: Parameter, share: np.ndarray) -> np.ndarray:
    """The numbers at shares of a range."""
    return p.low * (p.high / p.low) ** share if p.log else p.low + (p.high - p.low) * share


def ranks(merits: Sequence[float]) -> np.ndarray:
    """The share of candidates that are worse, in (0, 1): what the process goes through, whatever the scale of the objective."""
    return (rankdata(merits) - 0.5) / len(merits)


def process(x: np.ndarray, y: np.ndarray) -> Process:
    """Fit by the maximum of the marginal likelihood, with a wide prior on lengths (log-normal around 1, ±1)."""
    if len(x) > MOST:
        kept = np.linspace(0, len(x) - 1, MOST).astype(int)
        x, y = x[kept], y[kept]
    d, mean, scale = x.shape[1], float(y.mean()), float(y.var()) or 1.0

    def loss(theta: np.ndarray) -> float:
        k = _kernel(x, x, np.exp(theta[:d]), scale * np.exp(theta[d])) + scale * np.exp(theta[d + 1]) * np.eye(len(x))
        lower = cholesky(k, lower=True)
        z = np.linalg.solve(lower, y - mean)
        return float(0.5 * z @ z + np.log(np.diag(lower)).sum() + 0.5 * (theta[:d] ** 2).sum())

    bounds = [(-2.5, 3.0)] * d + [(-3.0, 2.0), (-5.0, 1.0)]
    found = minimize(loss, np.array([0.0] * d + [0.0, -1.0]), method="L-BFGS-B", bounds=bounds, options={"maxiter": 60})
    lengths, signal, noise = np.exp(found.x[:d]), scale * float(np.exp(found.x[d])), scale * float(np.exp(found.x[d + 1]))
    factor = cho_factor(_kernel(x, x, lengths, signal) + noise * np.eye(len(x)), lower=True)
    weights = cho_solve(factor, y - mean)
    left_out = weights / np.diag(cho_solve(factor, np.eye(len(x))))
    return Process(x, mean, lengths, signal, noise, weights, factor, float(1 - (left_out**2).mean() / scale))


def _kernel(a: np.ndarray, b: np.ndarray, lengths: np.ndarray, signal: float) -> np.ndarray:
    gap = (a[:, None] - b[None]) / lengths
    return signal * np.exp(-0.5 * (gap**2).sum(2))


def matters(fit: Process, names: Sequence[str], seed: int = 0) -> list[Matter]:
    """The share of variance of each number, over draws from the posterior (estimators of Saltelli et al. 2010)."""
    d = len(names)
    points = qmc.Sobol(2 * d, seed=seed).random(BASE)
    a, b = points[:, :d], points[:, d:]
    swapped = [np.where(np.arange(d) == i, b, a) for i in range(d)]
    everywhere = np.concatenate([a, b, *swapped])
    draws = _draw(fit, everywhere, seed).reshape(DRAWS, d + 2, BASE)
    fa, fb, fs = draws[:, 0], draws[:, 1], draws[:, 2:]
    variance = np.maximum(np.concatenate([fa, fb], 1).var(1), 1e-12)[:, None]
    first = (fb[:, None] * (fs - fa[:, None])).mean(2) / variance
    total = 0.5 * ((fa[:, None] - fs) ** 2).mean(2) / variance
    return [Matter(name, _interval(first[:, i]), _interval(total[:, i])) for i, name in enumerate(names)]


def _draw(fit: Process, points: np.ndarray, seed: int) -> np.ndarray:
    """Draws of the posterior at points: (DRAWS, k)."""
    spread = fit.spread(points)
    values, vectors = np.linalg.eigh(spread)
    normal = np.random.default_rng(seed).standard_normal((DRAWS, len(points)))
    return fit.foretell(points) + (normal * np.sqrt(np.maximum(values, 0))) @ vectors.T


def _interval(x: np.ndarray) -> tuple[float, float, float]:
    middle, low, high = np.clip(np.quantile(x, [0.5, 0.05, 0.95]), 0, 1)
    return float(middle), float(low), float(high)


def dependence(fit: Process, i: int, steps: int = 21, others: int = 64, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shares of the range of number i, and there the mean over all others with its standard deviation (partial dependence)."""
    grid = np.linspace(0, 1, steps)
    around = qmc.Sobol(fit.x.shape[1], seed=seed).random(others)
    points = np.repeat(around[None], steps, 0)
    points[:, :, i] = grid[:, None]
    flat = points.reshape(-1, fit.x.shape[1])
    mean = fit.foretell(flat).reshape(steps, others).mean(1)
    spread = fit.spread(flat).reshape(steps, others, steps, others).mean((1, 3))
    return grid, mean, np.sqrt(np.maximum(np.diag(spread), 0))
