"""Daily rhythms: fits of a cosine with a known period, and a test against days that begin at random hours."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Cosinor:
    """A fitted cosine (Nelson et al. 1979): mesor + amplitude × cos(2π t/period − acrophase)."""

    mesor: float
    amplitude: float  # half the difference between the highest and the lowest value
    acrophase: float  # [rad] in [0, 2π): 2π × time of the highest value / period

    @property
    def vector(self) -> np.ndarray:
        """The coefficients of cosine and sine, f64[2]; unlike acrophases, they can be averaged over runs."""
        return self.amplitude * np.array([np.cos(self.acrophase), np.sin(self.acrophase)])


def cosinor(times: np.ndarray, values: np.ndarray, period: float) -> Cosinor:
    """Fit a cosine with a known period by least squares.

    Parameters
    ----------
    times : array of float, shape (n,)
    values : array of float, shape (n,)
    period : float
        Period in the unit of the times.

    Returns
    -------
    Cosinor
        Mesor (mean), amplitude, and acrophase (phase of the maximum) [rad].

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.rhythm import cosinor
    >>> hours = np.arange(48.0)
    >>> fit = cosinor(hours, 10 + 3 * np.cos(2 * np.pi * (hours - 6) / 24), period=24.0)
    >>> round(fit.mesor, 6), round(fit.amplitude, 6)
    (10.0, 3.0)
    """
    angle = 2 * np.pi * np.asarray(times, float) / period
    design = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], 1)
    mesor, a, b = np.linalg.lstsq(design, np.asarray(values, float), rcond=None)[0]
    return Cosinor(float(mesor), float(np.hypot(a, b)), float(np.arctan2(b, a) % (2 * np.pi)))


def p_of_days(days: np.ndarray, n: int = 9999, seed: int = 1) -> float:
    """Return the probability that the mean of days f64[days, hours] has at least the observed amplitude if
    each day begins at a random hour.

    Whole days are shifted circularly, which preserves the correlations within a day. A straight line through
    all days is subtracted first, because a trend produces the same sawtooth every day.

    Parameters
    ----------
    days : array of float, shape (days, hours)
    n : int, default 9999
        Number of random shifts.
    seed : int, default 1
        Random seed for the shifts.

    Returns
    -------
    float

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.rhythm import p_of_days
    >>> p_of_days(np.tile(np.cos(2 * np.pi * np.arange(24) / 24), (5, 1)), n=999) < 0.01
    True
    """
    rng, (many, hours) = np.random.default_rng(seed), np.shape(days)
    time = np.arange(many * hours)
    level = np.ravel(np.asarray(days, float))
    level = level - np.polyval(np.polyfit(time, level, 1), time) if many > 1 else level
    wave = np.exp(2j * np.pi * np.arange(hours) / hours)
    each = level.reshape(many, hours) @ wave
    turned = each * np.exp(2j * np.pi * rng.integers(0, hours, (n, many)) / hours)
    return float((1 + (np.abs(turned.mean(1)) >= abs(each.mean()) - 1e-9).sum()) / (n + 1))
