"""The cycle that short series share: its period, and the phase and amplitude of each series. Two periods are
enough to measure a cycle but not to test it. Only compare series of similar length and sampling rate."""

from dataclasses import dataclass

import numpy as np

from ecs_eco.analysis.spectrum import detrend, thin
from ecs_eco.config.measurements import FEWEST

FINE = 16
"""Number of frequencies tried per Fourier frequency."""


@dataclass(frozen=True)
class Cycle:
    """The wave that explains the largest fraction of variance, averaged over simultaneous series."""

    period: float  # [samples]
    shares: np.ndarray  # fraction of each series' variance that the wave explains, f64[series]
    phases: np.ndarray  # lags behind the first series, in periods [0, 1), f64[series]
    swings: np.ndarray  # standard deviation of log10 of each series after removing the trend, f64[series]


def logarithms(numbers: np.ndarray) -> np.ndarray:
    """Return the detrended log10 of values: f64[n]. Zeros count as half the smallest positive number."""
    x = np.asarray(numbers, float)
    if x.ndim != 1 or len(x) < FEWEST:
        raise ValueError(f"a series of shape {x.shape}; expected one dimension and at least {FEWEST} numbers")
    if not np.isfinite(x).all() or (x < 0).any():
        at = int(np.flatnonzero(~np.isfinite(x) | (x < 0))[0])
        raise ValueError(f"sample {at} is {x[at]}; expected a number of organisms, 0 or more")
    if not x.any():
        raise ValueError("all numbers are 0, so there is no cycle to measure")
    return detrend(np.log10(np.maximum(x, x[x > 0].min() / 2)))


def cycle(*series: np.ndarray) -> Cycle:
    """Return the cycle that simultaneous series share.

    Waves with periods between 3 samples and two thirds of the series are fitted by least squares, together
    with a straight line (a Lomb-Scargle periodogram with a floating trend).

    Parameters
    ----------
    *series : array of float, shape (samples,)
        Numbers of organisms in simultaneous samples, at least 12.

    Returns
    -------
    Cycle

    Raises
    ------
    ValueError
        If a series is too short, all zero, or contains a negative or missing number.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.signature import cycle
    >>> t = 2 * np.pi * np.arange(40) / 10
    >>> found = cycle(100 + 50 * np.sin(t), 20 + 10 * np.sin(t - np.pi / 2))
    >>> round(found.period), found.phases.round(2).tolist()
    (10, [0.0, 0.25])
    """
    logs = [logarithms(x) for x in series]
    f, shares, waves = _waves(logs)
    at = shares.sum(0).argmax()
    turns = np.angle(waves[0, at] * waves[:, at].conj())
    return Cycle(
        float(1 / f[at]), shares[:, at], turns / (2 * np.pi) % 1 % 1, np.array([x.std() for x in logs])
    )


def spectrum(numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies [1/sample], and the fraction of a series' variance that a wave of each explains."""
    f, shares, _ = _waves([logarithms(numbers)])
    return f, shares[0]


def period_of(*series: np.ndarray) -> float:
    """Return the period of the `cycle` of one series or of several simultaneous series.

    Parameters
    ----------
    *series : array of float, shape (samples,)
        Numbers of organisms in simultaneous samples, at least 12; long series are thinned first.

    Returns
    -------
    float
        [samples]

    Raises
    ------
    ValueError
        As for `cycle`.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.signature import period_of
    >>> round(period_of(100 + 50 * np.sin(2 * np.pi * np.arange(40) / 10)))
    10
    """
    thinned = [thin(np.asarray(x, float)) for x in series]
    return float(thinned[0][1] * cycle(*(x for x, _ in thinned)).period)


def _waves(series: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fit waves to detrended series f64[n]; return frequencies [1/sample], the fraction of the variance that
    each explains, f64[series, frequency], and the fitted waves, complex[series, frequency]."""
    n = len(series[0])
    f = np.arange(int(np.ceil(1.5 * FINE)), n * FINE // 3 + 1) / (FINE * n)
    t = np.arange(n) - (n - 1) / 2
    basis = np.stack([np.ones(n), t], 1)
    waves = np.stack([np.cos(2 * np.pi * f[:, None] * t), np.sin(2 * np.pi * f[:, None] * t)], 2)
    q, _ = np.linalg.qr(basis)
    waves -= q @ (q.T @ waves)  # the part that a straight line cannot fit
    q, r = np.linalg.qr(waves)
    y = np.stack(series, 1)
    along = np.swapaxes(q, 1, 2) @ y  # [frequency, 2, series]
    total = np.maximum((y**2).sum(0), 1e-300)
    amplitudes = np.linalg.solve(r, along)
    return f, ((along**2).sum(1) / total).T, (amplitudes[:, 0] - 1j * amplitudes[:, 1]).T
