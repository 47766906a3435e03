"""A test for cycles in a population series, based on spectral peaks above red noise.

Populations are red noise: they drift without cycling, and a test against white noise classifies nearly every
such series as periodic. The null hypothesis here is a series that relaxes without oscillating. "ar1" has one
rate of relaxation (AR(1), Ornstein-Uhlenbeck), as usual for climate and population records. "relaxation",
the null of reported p values, has two rates and a moving-average root: ARMA(2, 1) with real roots, whose
spectrum never rises. It includes AR(1), sums of two AR(1) series, and a population that integrates a
fluctuating birth rate with added noise from births and deaths, which AR(1) nearly always classifies as
periodic. A peak above "relaxation" requires complex roots: a quasi-cycle or a limit cycle. Test raw
population sizes, never smoothed ones, because smoothing adds rates of relaxation."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

SAMPLES = 512
"""Maximum number of samples tested; longer series are thinned by block means (`thin`)."""
SHORTEST = 96
"""Minimum number of samples tested."""
MIN_CYCLES = 4
"""Minimum number of periods in the series for a peak to count."""
BAND = 1.6
"""The band around a period ranges from period / BAND to period × BAND."""
RECURRENCES = 3
"""Minimum number of times that a series must contain a period for it to be reported."""
TAPERS = 2
GRID = {"ar1": 100, "relaxation": 24}
"""Number of values tried for each root, from white noise to a memory of 1,000 samples."""


def thin(series: np.ndarray, samples: int = SAMPLES) -> tuple[np.ndarray, int]:
    """Return means over blocks of ticks, to shorten a series.

    Parameters
    ----------
    series : array of float, shape (…, ticks)
    samples : int, default 512
        Maximum number of blocks.

    Returns
    -------
    means : array of float64, shape (…, blocks)
    factor : int
        Ticks per block, as few as possible. The remainder at the start is dropped.

    Examples
    --------
    >>> from ecs_eco.analysis.spectrum import thin
    >>> means, factor = thin([9, 1, 3, 5, 7], samples=2)
    >>> means.tolist(), factor
    ([5.0], 3)
    """
    x = np.asarray(series, float)
    factor = max(1, -(-x.shape[-1] // samples))
    n = x.shape[-1] // factor
    return x[..., x.shape[-1] - n * factor :].reshape(*x.shape[:-1], n, factor).mean(-1), factor


def smooth(series: np.ndarray, window: int) -> np.ndarray:
    """Return the centered running mean over `window` ticks (made odd), with shorter windows at the ends."""
    x = np.asarray(series, float)
    half = min(int(window) // 2, len(x) - 1)
    total = np.concatenate([[0.0], np.cumsum(x)])
    at = np.arange(len(x))
    low, high = np.maximum(at - half, 0), np.minimum(at + half + 1, len(x))
    return (total[high] - total[low]) / (high - low)


def transform(numbers: np.ndarray, how: str = "log") -> np.ndarray:
    """Return population sizes on a scale that makes fluctuations similar in size.

    Parameters
    ----------
    numbers : array of float
    how : {"log", "sqrt", "none"}, default "log"
        "log" is log(n + 1), because births and deaths are multiplicative and cycles span orders of magnitude.
        "sqrt" equalizes the demographic noise of a population that varies little.

    Returns
    -------
    array of float64

    Raises
    ------
    ValueError
        If `how` is unknown.

    Examples
    --------
    >>> from ecs_eco.analysis.spectrum import transform
    >>> transform([0, 4, 9], how="sqrt").tolist()
    [0.0, 2.0, 3.0]
    """
    x = np.asarray(numbers, float)
    if how == "log":
        return np.log1p(x)
    if how == "sqrt":
        return np.sqrt(x)
    if how == "none":
        return x
    raise ValueError(f'transform {how!r}: expected "log", "sqrt" or "none"')


def detrend(x: np.ndarray) -> np.ndarray:
    """Return the residuals from a straight line, along the last axis.

    Parameters
    ----------
    x : array of float, shape (…, samples)

    Returns
    -------
    array of float, shape (…, samples)

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.spectrum import detrend
    >>> bool(np.allclose(detrend(np.array([1.0, 3.0, 5.0])), 0))
    True
    """
    t = (np.arange(x.shape[-1]) - (x.shape[-1] - 1) / 2).astype(x.dtype)
    centred = x - x.mean(-1, keepdims=True)
    return centred - (centred @ t)[..., None] / (t @ t) * t


def spectrum(x: np.ndarray) -> np.ndarray:
    """Return the sine-multitaper spectrum (Riedel and Sidorenko 1995) of the detrended series.

    Parameters
    ----------
    x : array of float, shape (…, samples)

    Returns
    -------
    array of float64, shape (…, samples // 2 + 1)
        Power at the frequencies k / samples.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.spectrum import spectrum
    >>> int(spectrum(np.sin(2 * np.pi * np.arange(100) / 10)).argmax())
    10
    """
    n = x.shape[-1]
    x = detrend(x)
    total = np.zeros((*x.shape[:-1], n // 2 + 1))
    for k in range(1, TAPERS + 1):
        taper = np.sqrt(2 / (n + 1)) * np.sin(np.pi * k * np.arange(1, n + 1) / (n + 1))
        part = np.fft.rfft(x * taper.astype(x.dtype))
        total += part.real**2 + part.imag**2
    return total / TAPERS


class RedNoise:
    """Red noise per tick that is observed as block means over `factor` ticks and fitted to spectra by Whittle
    likelihood (Whittle 1953). The parameters are two relaxation roots r ≥ s and a moving-average root m ≤ r,
    each per block (root ** (1 / factor) per tick). The spectra are those of block means and include aliasing:
    block means of AR(1) are not AR(1), and treating them as AR(1) classifies 37% of them as periodic."""

    def __init__(self, n: int, factor: int, null: str):
        if null not in GRID:
            raise ValueError(f"null {null!r}: expected one of {', '.join(map(repr, GRID))}")
        self.n, self.factor = n, factor
        grid = 1 - np.geomspace(1e-3, 1.0, GRID[null])
        if null == "ar1":
            self.roots = np.array([(r, 0.0, 0.0) for r in grid])
        else:
            pairs = [(r, s) for i, r in enumerate(grid) for s in grid[i:]]
            self.roots = np.array([(r, s, m) for r, s in pairs for m in grid if m <= r])
        self._shape = self.shape(self.roots, n)
        used = self._shape[:, 2:]  # detrending removes the lowest two frequencies
        self._inverse = (1 / used).astype(np.float32)
        self._log = np.log(used).mean(1)

    def shape(self, roots: np.ndarray, n: int) -> np.ndarray:
        """Return spectra for unit innovations at the Fourier frequencies of n block means, one per row of roots."""
        per_tick = roots ** (1 / self.factor)
        total = np.zeros((len(roots), n // 2 + 1))
        for alias in range(self.factor):
            f = (np.arange(n // 2 + 1) / n + alias) / self.factor  # [1/tick]
            with np.errstate(invalid="ignore"):
                block = np.sin(np.pi * self.factor * f) / (self.factor * np.sin(np.pi * f))
            block[f == 0] = 1.0
            lag = 2 * np.cos(2 * np.pi * f)
            r, s, m = (1 + root[:, None] ** 2 - root[:, None] * lag for root in per_tick.T)
            total += block**2 * m / (r * s)
        return total

    def fit(self, spectra: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the roots of each spectrum's best null, and the ratio of the spectrum to that null."""
        used = spectra[:, 2:].astype(np.float32)
        scale = used @ self._inverse.T / used.shape[1]
        best = (np.log(scale) + self._log).argmin(1)
        return self.roots[best], spectra / (self._shape[best] * scale[np.arange(len(best)), best][:, None])

    def draw(self, roots: np.ndarray, waves: np.ndarray) -> np.ndarray:
        """Turn Fourier transforms of white noise into n-sample series, cut from circular series of 4 n samples."""
        gain = np.sqrt(self.shape(roots[None], 4 * self.n)[0]).astype(np.float32)
        return np.fft.irfft(waves * gain, 4 * self.n)[:, : self.n]


@lru_cache(maxsize=4)
def _white(n_boot: int, length: int, seed: int) -> np.ndarray:
    """Return Fourier transforms of white-noise series, which all tests with the same seed share."""
    return np.fft.rfft(np.random.default_rng(seed).standard_normal((n_boot, length), dtype=np.float32))


_red_noise = lru_cache(maxsize=4)(RedNoise)


@dataclass(frozen=True)
class Peak:
    """The strongest departure of a spectrum from red noise."""

    p: float  # probability of a ratio this high at any frequency under the null
    period: float  # [ticks]
    n_periods: float  # periods in the series
    ratio: float  # spectrum / null at the peak
    held: float  # effective number of periods: n_periods, or fewer if only some are large
    slower: float  # variance of the largest slower swing, divided by the variance in the band
    null: str
    frequency: np.ndarray  # [1/tick]
    power: np.ndarray
    expected: np.ndarray  # the fitted null
    limit: np.ndarray  # at each frequency, 1 in 20 ratios under the null exceeds this

    @property
    def recurs(self) -> bool:
        """True if the period can be reported: the series contains it at least three times, and no slower swing
        is larger. A boom and its crash, an initial transient that dies away, and bumps on a long swing do not
        recur, however far they rise above red noise."""
        return self.held >= RECURRENCES and self.slower <= 1


def spectral_peak(
    series: np.ndarray,
    *,
    null: str = "relaxation",
    how: str = "log",
    samples: int = SAMPLES,
    n_boot: int = 499,
    min_cycles: float = MIN_CYCLES,
    seed: int = 0,
) -> Peak | None:
    """Return a population's strongest spectral peak, and its p value from a parametric bootstrap of red noise.

    Parameters
    ----------
    series : array of float, shape (ticks,)
        Raw population sizes, never smoothed.
    null : {"relaxation", "ar1"}, default "relaxation"
        Red noise to test against: with one rate of relaxation ("ar1"), or with two and a moving-average root.
    how : {"log", "sqrt", "none"}, default "log"
        Scale, as in `transform`.
    samples : int, default 512
        Maximum number of samples tested; longer series are thinned.
    n_boot : int, default 499
        Number of red-noise simulations.
    min_cycles : float, default 4
        Minimum number of periods in the series.
    seed : int, default 0
        Random seed for the simulations.

    Returns
    -------
    Peak or None
        None for constant series and for fewer than 96 samples.

    Raises
    ------
    ValueError
        If `null` or `how` is unknown.

    Notes
    -----
    The statistic is the largest ratio of the spectrum to the fitted null over all periods from 4 samples to
    1/min_cycles of the series, which accounts for testing many frequencies. The null is refitted to every
    bootstrap series, so that the fit has the same bias for observed and simulated series; correcting this
    bias did not change error rates.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.spectrum import spectral_peak
    >>> peak = spectral_peak(100 + 50 * np.sin(2 * np.pi * np.arange(1000) / 50), n_boot=99)
    >>> round(peak.period), peak.recurs
    (50, True)
    """
    x, factor = thin(transform(series, how), samples)
    n = x.shape[-1]
    if n < SHORTEST or np.ptp(x) < 1e-12 or not np.isfinite(x).all():
        return None
    red = _red_noise(n, factor, null)
    power = spectrum(x[None])
    power /= power.mean()
    roots, ratio = red.fit(power)
    drawn = red.fit(spectrum(red.draw(roots[0], _white(n_boot, 4 * n, seed))))[1]
    low, high = int(np.ceil(min_cycles)), n // 4
    best = low + int(ratio[0, low : high + 1].argmax())
    p = (1 + np.count_nonzero(drawn[:, low : high + 1].max(1) >= ratio[0, best])) / (n_boot + 1)
    near = np.arange(max(low, int(best / 1.4)), min(high, int(np.ceil(best * 1.4))) + 1)
    cycles = float((near * power[0, near]).sum() / power[0, near].sum())  # center of mass around the peak
    return Peak(
        p=float(p),
        period=float(factor * n / cycles),
        n_periods=float(cycles),
        ratio=float(ratio[0, best]),
        **_recurrence(x, n / cycles),
        null=null,
        frequency=np.arange(n // 2 + 1) / (n * factor),
        power=power[0],
        expected=power[0] / ratio[0],
        limit=np.quantile(drawn, 0.95, axis=0),
    )


def _recurrence(x: np.ndarray, period: float) -> dict[str, float]:
    """Return `held` and `slower` for a peak at a period [samples of x]. `held` is n_periods times the
    participation ratio (Σ|z|²)² / (n Σ|z|⁴) of the analytic signal z in the band: 1 for a steady wave, 1/2
    for noise in a narrow band, less for a short burst."""
    energy = np.abs(waves(x, period)) ** 2
    steady = energy.sum() ** 2 / (len(x) * (energy**2).sum())
    slower, longer = 0.0, period * BAND**2
    while longer < 2 * len(x):
        slower, longer = max(slower, float((np.abs(waves(x, longer)) ** 2).mean())), longer * BAND
    return {"held": float(steady * len(x) / period), "slower": float(slower / energy.mean())}


def waves(x: np.ndarray, period: float) -> np.ndarray:
    """Return the detrended analytic signal in the band around `period` [samples], along the last axis."""
    n = x.shape[-1]
    cycles = np.arange(n) * period / n  # frequency relative to that of the peak
    with np.errstate(divide="ignore"):
        octave = np.abs(np.log(cycles)) / np.log(BAND)
    gain = np.where(
        (octave < 1) & (np.arange(n) <= n // 2), np.cos(np.pi / 2 * np.minimum(octave, 1)) ** 0.5, 0.0
    )
    return np.fft.ifft(2 * np.fft.fft(detrend(np.asarray(x, float))) * gain)
