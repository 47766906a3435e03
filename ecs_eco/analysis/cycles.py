"""Cycles in a food chain: which species cycle, their periods and lags. Independent quasi-cycles of ten periods
can have a cross-correlation of 0.5, so coupling is tested against pairs of different runs."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from itertools import combinations, permutations
from typing import Any

import numpy as np

from ecs_eco.analysis import quantiles
from ecs_eco.analysis.runs import Series, load_series
from ecs_eco.analysis.spectrum import SHORTEST, Peak, detrend, spectral_peak, thin, transform, waves

LAG_SAMPLES = 2048
BLOCK = 3
"""Periods per bootstrap block; with one-period blocks, 95% intervals have only 70% coverage."""


@dataclass(frozen=True)
class Lag:
    """Lag of b behind a as a fraction of the period in [0, 1), its 95% interval and the coherence in [0, 1]."""

    share: float
    low: float  # does not wrap around at 0
    high: float  # does not wrap around at 1
    coherence: float


@dataclass(frozen=True)
class CycleStatistics:
    """The cycles of one run; `as_dict` converts them to JSON types.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.cycles import cycle_statistics
    >>> hares = 100 + 50 * np.sin(2 * np.pi * np.arange(2000) / 100)
    >>> statistics = cycle_statistics({"hare": hares}, n_boot=99)
    >>> statistics.cycling(), statistics.as_dict()["enough"]
    (('hare',), True)
    """

    species: tuple[str, ...]
    ticks: int  # length of the analyzed stretch: after the start, before the first extinction
    enough: bool  # whether that stretch is long enough to analyze
    peaks: dict[str, Peak | None] = field(default_factory=dict)  # compared with red noise without cycles
    p_ar1: dict[str, float | None] = field(default_factory=dict)  # p value against AR(1), the lenient null
    # [ticks] period of the clearest peak (recurring if possible) among `period_of`; lags refer to it
    period: float | None = None
    period_of: tuple[str, ...] = ()  # species whose peaks were considered for the period
    lags: dict[str, Lag] = field(default_factory=dict)  # "grass→deer": …

    def cycling(self, level: float = 0.05) -> tuple[str, ...]:
        """Return the species that cycle, i.e. have a recurring spectral peak above red noise.

        Parameters
        ----------
        level : float, default 0.05
            Significance level.

        Returns
        -------
        tuple of str
        """
        known = ((s, peak) for s in self.species if (peak := self.peaks.get(s)) is not None)
        return tuple(s for s, peak in known if peak.p <= level and peak.recurs)

    def as_dict(self) -> dict[str, Any]:
        """Return the statistics as numbers and strings, without spectra.

        Returns
        -------
        dict
        """
        kept = ("p", "period", "n_periods", "ratio", "held", "slower", "recurs")
        peaks = {s: None if p is None else {k: getattr(p, k) for k in kept} for s, p in self.peaks.items()}
        return {
            "ticks": self.ticks,
            "enough": self.enough,
            "cycling": list(self.cycling()),
            "peaks": peaks,
            "p_ar1": self.p_ar1,
            "period": self.period,
            "period_of": list(self.period_of),
            "lags": {pair: asdict(lag) for pair, lag in self.lags.items()},
        }


def living_stretch(series: Series, skip: float = 0.1) -> np.ndarray:
    """Return population sizes after the start of a run and before its first extinction.

    Parameters
    ----------
    series : Series
    skip : float, default 0.1
        Fraction of the run to skip at the start.

    Returns
    -------
    array of float64, shape (ticks, species)
        Only species that were ever present.

    Examples
    --------
    >>> from ecs_eco.analysis.cycles import living_stretch
    >>> from ecs_eco.analysis.runs import load_series
    >>> living_stretch(load_series({"hare": [10, 12, 9, 0]}), skip=0.25).ravel().tolist()
    [12.0, 9.0]
    """
    n = series.n[:, series.present]
    gone = np.flatnonzero((n == 0).any(1))
    end = gone[0] if len(gone) else len(n)
    return n[min(int(skip * len(series.n)), end) : end]


def consumers(config: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the species of a resolved configuration (`manifest["config"]`) that eat another species."""
    species = config.get("species", {})
    eaten = {name: {food["eats"] for food in about.get("diet") or ()} for name, about in species.items()}
    return tuple(name for name, of in eaten.items() if of & (set(species) - {name}))


def cycle_statistics(
    run: Any,
    species: Sequence[str] | None = None,
    *,
    skip: float = 0.1,
    n_boot: int = 499,
    seed: int = 0,
    period_of: Sequence[str] | None = None,
) -> CycleStatistics:
    """Return the spectral peaks, periods and lags of a run.

    Parameters
    ----------
    run : str, Path, pyarrow.Table, Mapping or Series
        Anything that `load_series` accepts.
    species : sequence of str, optional
        Species, from producers upward; default: all.
    skip : float, default 0.1
        Fraction of the run to skip at the start.
    n_boot : int, default 499
        Number of red-noise simulations.
    seed : int, default 0
        Random seed for the simulations.
    period_of : sequence of str, optional
        Species whose clearest peak sets the period of the lags; default: the consumers if the manifest
        contains diets, otherwise all.

    Returns
    -------
    CycleStatistics

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.cycles import cycle_statistics
    >>> t = np.arange(2000)
    >>> hares = 100 + 50 * np.sin(2 * np.pi * t / 100)
    >>> lynx = 20 + 10 * np.sin(2 * np.pi * (t / 100 - 0.25))
    >>> statistics = cycle_statistics({"hare": hares, "lynx": lynx}, n_boot=99)
    >>> round(statistics.period), round(statistics.lags["hare→lynx"].share, 2)
    (100, 0.25)
    """
    series = load_series(run, species)
    names = tuple(series.there)
    searched = _asked(series, names, period_of)
    n = living_stretch(series, skip)
    if len(n) < SHORTEST:
        return CycleStatistics(names, len(n), False, period_of=searched)
    peaks = {s: spectral_peak(x, n_boot=n_boot, seed=seed) for s, x in zip(names, n.T, strict=True)}
    lenient = [spectral_peak(x, null="ar1", n_boot=n_boot, seed=seed) for x in n.T]
    p_ar1 = {s: None if peak is None else peak.p for s, peak in zip(names, lenient, strict=True)}
    candidates = [peak for s in searched if (peak := peaks[s]) is not None]
    if not candidates:
        return CycleStatistics(names, len(n), True, peaks, p_ar1, period_of=searched)
    period = min(candidates, key=lambda peak: (not peak.recurs, peak.p, -peak.ratio)).period
    log = transform(n)
    lags = {
        f"{names[i]}→{names[j]}": lag(log[:, i], log[:, j], period, seed=seed)
        for i, j in combinations(range(len(names)), 2)
        if np.ptp(n[:, [i, j]], 0).all()
    }
    return CycleStatistics(names, len(n), True, peaks, p_ar1, period, searched, lags)


def _asked(series: Series, names: Sequence[str], period_of: Sequence[str] | None) -> tuple[str, ...]:
    """Return the species whose peaks set the period: those passed, the consumers, or all."""
    if period_of is not None:
        for name in period_of:
            series.index(name)
        return tuple(s for s in names if s in period_of)
    return tuple(s for s in consumers(series.manifest.get("config", {})) if s in names) or tuple(names)


def lag(a: np.ndarray, b: np.ndarray, period: float, *, n_boot: int = 999, seed: int = 0) -> Lag:
    """Return the lag of b behind a: the phase of their cross-spectrum in the band around `period`.

    Parameters
    ----------
    a, b : array of float, shape (samples,)
        Logarithms of simultaneous population sizes.
    period : float
        Period around which the series are filtered [samples].
    n_boot : int, default 999
        Number of bootstrap samples.
    seed : int, default 0
        Random seed for the bootstrap.

    Returns
    -------
    Lag
        The interval (circular block bootstrap with blocks of three periods, and Student's t) has 90% coverage
        with 10 to 20 periods.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.cycles import lag
    >>> t = np.arange(1000) / 50
    >>> round(lag(np.sin(2 * np.pi * t), np.sin(2 * np.pi * (t - 0.25)), period=50).share, 2)
    0.25
    """
    (a, factor), (b, _) = thin(a, LAG_SAMPLES), thin(b, LAG_SAMPLES)
    period = period / factor
    za, zb = waves(a, period), waves(b, period)
    cross, weight = za * zb.conj(), np.sqrt((np.abs(za) ** 2).mean() * (np.abs(zb) ** 2).mean())
    n = len(cross)
    block = int(np.clip(round(BLOCK * period), 1, n // 2))
    running = np.concatenate([[0], np.cumsum(np.concatenate([cross, cross[:block]]))])
    sums = running[block : block + n] - running[:n]
    starts = np.random.default_rng(seed).integers(0, n, (n_boot, -(-n // block)))
    phase = np.angle(cross.mean())
    off = np.angle(sums[starts].sum(1) * np.exp(-1j * phase)) / (2 * np.pi)
    share = float(phase / (2 * np.pi) % 1)
    blocks = max(n / block, 3.0)
    wider = quantiles.student(blocks - 1, 0.95) / quantiles.normal(0.95) * np.sqrt(blocks / (blocks - 1))
    low, high = np.clip(np.quantile(off, [0.025, 0.975]) * wider, -0.5, 0.5)
    coherence = float(np.abs(cross.mean()) / weight) if weight else 0.0
    return Lag(share, share + float(low), share + float(high), coherence)


def median_lag_interval(lags: Sequence[float], level: float = 0.95) -> dict[str, float]:
    """Return the circular median of lags over seeds, and a distribution-free interval between order statistics.

    Parameters
    ----------
    lags : sequence of float, shape (seeds,)
        Lags as fractions of the period.
    level : float, default 0.95

    Returns
    -------
    dict
        `n`, `median`, `low`, `high` and `coverage`. The interval is the narrowest that covers `level`; if none
        does, it is the full range (`coverage` 0.97 for six seeds). Without lags, the values are NaN.

    Examples
    --------
    >>> from ecs_eco.analysis.cycles import median_lag_interval
    >>> found = median_lag_interval([0.2, 0.22, 0.24, 0.26, 0.28])
    >>> round(found["median"], 2), round(found["low"], 2), round(found["high"], 2)
    (0.24, 0.2, 0.28)
    """
    from scipy.special import bdtr

    x = np.asarray(lags, float)
    if not len(x):
        return {"n": 0, "median": np.nan, "low": np.nan, "high": np.nan, "coverage": 0.0}
    centre = np.angle(np.exp(2j * np.pi * x).mean()) / (2 * np.pi)
    near = np.sort((x - centre + 0.5) % 1 - 0.5)
    off = (centre % 1) if (centre % 1) + near.min() > -0.5 else centre
    n, out = len(x), 1
    while out < n // 2 and 1 - 2 * bdtr(out, n, 0.5) >= level:
        out += 1
    return {
        "n": n,
        "median": float((np.median(near) + off) % 1),
        "low": float(near[out - 1] + off),
        "high": float(near[n - out] + off),
        "coverage": float(1 - 2 * (bdtr(out - 1, n, 0.5) if out else 0.0)),
    }


def cross_correlation(a: np.ndarray, b: np.ndarray, reach: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the correlations of detrended a(t) with b(t + lag).

    Parameters
    ----------
    a, b : array of float, shape (samples,)
    reach : int
        Largest lag [samples].

    Returns
    -------
    lags : array of int, shape (k,)
        From −reach to reach.
    correlations : array of float64, shape (k,)

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.cycles import cross_correlation
    >>> a = np.random.default_rng(1).standard_normal(100)
    >>> lags, correlations = cross_correlation(a, np.roll(a, 3), reach=5)
    >>> lags[correlations.argmax()].item()
    3
    """
    a, b = detrend(np.asarray(a, float)), detrend(np.asarray(b, float))
    n = len(a)
    full = np.fft.irfft(np.fft.rfft(a, 2 * n).conj() * np.fft.rfft(b, 2 * n), 2 * n)
    lags = np.arange(-min(reach, n - 1), min(reach, n - 1) + 1)
    return lags, full[lags] / (np.sqrt((a @ a) * (b @ b)) or 1.0)


@dataclass(frozen=True)
class Surrogates:
    """Real pairs (a and b from the same run) compared with pairs from different runs."""

    n: int  # runs
    # |mean over real pairs of the complex coherency|: high if all pairs are coherent at the same lag
    coherency: float
    p: float  # probability under random pairing of runs
    share: float  # the pooled lag, as a fraction of the period
    lags: np.ndarray  # [periods] lags of the cross-correlations
    real: np.ndarray  # (runs, lags)
    low: np.ndarray  # 95% band of the cross-seed pairs at each lag
    high: np.ndarray


def cross_seed_surrogates(
    runs: Sequence[Any],
    a: str,
    b: str,
    period: float | None = None,
    *,
    skip: float = 0.1,
    n_shuffles: int = 9999,
    seed: int = 0,
) -> Surrogates:
    """Test whether a and b from the same run are coupled more strongly than a from run i and b from run j.

    All runs are truncated to the length of the shortest stretch before an extinction.

    Parameters
    ----------
    runs : sequence
        At least 4 runs, one per seed: anything that `load_series` accepts.
    a, b : str
        Two species.
    period : float, optional
        Period around which all runs are filtered [ticks]; default: the median of their clearest peaks.
    skip : float, default 0.1
        Fraction of each run to skip at the start.
    n_shuffles : int, default 9999
        Number of random pairings of more than seven runs.
    seed : int, default 0
        Random seed for the pairings.

    Returns
    -------
    Surrogates
        p comes from a permutation test over the pairings of runs, which is exact for up to seven runs. It is at
        least 1/n! for n runs.

    Raises
    ------
    ValueError
        If there are fewer than 4 runs, or the shortest run covers fewer than two periods.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.cycles import cross_seed_surrogates
    >>> x = np.random.default_rng(0).normal(100, 9, (5, 400))
    >>> runs = [{"hare": n, "lynx": np.roll(n, 5)} for n in x]
    >>> cross_seed_surrogates(runs, "hare", "lynx", period=20).p <= 0.05
    True
    """
    if len(runs) < 4:
        raise ValueError(
            f"cross-seed surrogates need at least 4 runs, got {len(runs)}: give one run per seed"
        )
    loaded = [load_series(run) for run in runs]
    if period is None:  # the median period of the runs' clearest peaks
        statistics = [cycle_statistics(s, (a, b), skip=skip, n_boot=99, seed=seed) for s in loaded]
        periods = [s.period for s in statistics if s.period]
        if not periods:
            raise ValueError(f"none of the {len(loaded)} runs is long enough for a cycle of {a} and {b}")
        period = float(np.median(periods))
    pairs = [living_stretch(load_series(s, (a, b)), skip) for s in loaded]
    n = min(map(len, pairs))
    if n < 2 * period:
        fault = f"the shortest run has {n} ticks before its first extinction"
        raise ValueError(f"{fault}: fewer than two periods of {period:.0f} ticks")
    numbers, factor = thin(transform(np.stack([x[len(x) - n :].T for x in pairs])), LAG_SAMPLES)
    z = waves(numbers, period / factor)
    z = z / np.linalg.norm(z, axis=-1, keepdims=True)
    coherency = z[:, 0] @ z[:, 1].conj().T  # (run of a, run of b)
    pooled = np.trace(coherency) / len(runs)
    rows = np.arange(len(runs))
    if len(runs) <= 7:  # every pairing
        order = np.array(list(permutations(rows)))
    else:  # the real pairing, and random ones
        shuffled = np.random.default_rng(seed).permuted(np.tile(rows, (n_shuffles, 1)), axis=1)
        order = np.vstack([rows, shuffled])
    null = np.abs(coherency[rows, order].mean(1))
    reach = round(period / factor)
    curves = np.array([[cross_correlation(x[0], y[1], reach)[1] for y in numbers] for x in numbers])
    lags = np.arange(-(curves.shape[-1] // 2), curves.shape[-1] // 2 + 1) * factor / period
    same = np.eye(len(runs), dtype=bool)
    low, high = np.quantile(curves[~same], [0.025, 0.975], axis=0)
    return Surrogates(
        n=len(runs),
        coherency=float(np.abs(pooled)),
        p=float(np.mean(null >= np.abs(pooled) - 1e-12)),
        share=float(np.angle(pooled) / (2 * np.pi) % 1),
        lags=lags,
        real=curves[same],
        low=low,
        high=high,
    )
