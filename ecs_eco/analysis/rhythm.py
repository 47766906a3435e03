"""Daily rhythms: a cosine of a known period, and its test against days that begin at random hours."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Cosinor:
    """A cosine fitted to a series by least squares (Nelson et al. 1979): mesor + amplitude × cos(2π t/period
    − acrophase)."""

    mesor: float
    amplitude: float  # half of the difference between highest and lowest value
    acrophase: float  # [rad] in [0, 2π): 2π × time of the highest value / period

    @property
    def vector(self) -> np.ndarray:
        """The coefficients of cosine and sine, f64[2]. Vectors of several runs can be averaged, acrophases
        cannot."""
        return self.amplitude * np.array([np.cos(self.acrophase), np.sin(self.acrophase)])


def cosinor(times: np.ndarray, values: np.ndarray, period: float) -> Cosinor:
    """Fit a cosine of a known period to values f64[n] at times f64[n]."""
    angle = 2 * np.pi * np.asarray(times, float) / period
    design = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], 1)
    mesor, a, b = np.linalg.lstsq(design, np.asarray(values, float), rcond=None)[0]
    return Cosinor(float(mesor), float(np.hypot(a, b)), float(np.arctan2(b, a) % (2 * np.pi)))


def p_of_days(days: np.ndarray, n: int = 9999, seed: int = 1) -> float:
    """Return the probability that days f64[days, hours], each begun at a random hour, give a mean day with an
    amplitude at least as large.

    Whole days are shifted circularly, which keeps the correlations within a day. A straight line through all
    days is subtracted first, because a drift produces the same sawtooth in every day.
    """
    rng, (many, hours) = np.random.default_rng(seed), np.shape(days)
    time = np.arange(many * hours)
    level = np.ravel(np.asarray(days, float))
    level = level - np.polyval(np.polyfit(time, level, 1), time) if many > 1 else level
    wave = np.exp(2j * np.pi * np.arange(hours) / hours)
    each = level.reshape(many, hours) @ wave
    turned = each * np.exp(2j * np.pi * rng.integers(0, hours, (n, many)) / hours)
    return float((1 + (np.abs(turned.mean(1)) >= abs(each.mean()) - 1e-9).sum()) / (n + 1))
