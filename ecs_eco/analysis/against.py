"""A run beside an outside series: period, amplitude and lags of both, by the same rule, however short they
are.

The tests of significance of `ecs_eco.analysis.spectrum` need 96 samples and several periods; counts from the
field are often shorter. What is said here is therefore a description, of a series as of the other, and no
test.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from itertools import permutations
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ecs_eco.analysis.runs import Series
from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest

SHORTEST = 8  # samples
FINE = 8  # as many frequencies for each that the length alone gives
MOST_BYTES = 20_000_000


class Outside(NamedTuple):
    """An outside series: evenly spaced times f64[n], and columns f64[n] by the name of the species that each
    stands beside; `named` is what the file calls them."""

    times: np.ndarray
    columns: dict[str, np.ndarray]
    named: dict[str, str]
    unit: str  # what the file calls its time

    @property
    def step(self) -> float:
        """Time from one sample to the next."""
        return float(self.times[1] - self.times[0])


class Summary(NamedTuple):
    """One series in numbers."""

    samples: int
    period: float  # of the highest peak of the spectrum [of its time]
    cycles: float  # how many of them it holds
    share: float  # of the variance, in the band around that peak
    amplitude: float  # standard deviation of the numbers on a scale of log10


class Both(NamedTuple):
    """The summaries of one species in the run [ticks] and outside, and the lags behind other species."""

    run: dict[str, Summary]
    outside: dict[str, Summary]
    lags: dict[tuple[str, str], tuple[float, float]]  # of b behind a, shares of the period: run, outside


def read_outside(file: str | Path, species: Sequence[str], match: Mapping[str, str] | None = None) -> Outside:
    """Read a CSV whose first column is time; `match` gives the species that a column stands beside, where it
    is not named as one.

    Rows without a number in a column that is used are left out at the ends. Raises ConfigError.
    """
    head, rows = _rows(Path(file))
    named = {name: name for name in head[1:] if name in species}
    for column, name in (match or {}).items():
        if column not in head[1:]:
            raise _refused("--match", "no column of this name", column, listed(head[1:]),
                           nearest(column, head[1:]))
        if name not in species:
            raise _refused("--match", "no species of this name", name, listed(species),
                           nearest(name, species))
        named = {k: v for k, v in named.items() if v != name} | {column: name}
    if not named:
        raise _refused("--against", "no column is named as a species", str(file),
                       f"--match COLUMN=SPECIES, of columns {listed(head[1:])} and species {listed(species)}")
    table = np.array([[_number(row[head.index(name)]) for name in (head[0], *named)] for row in rows], float)
    table = table.reshape(-1, 1 + len(named))
    whole = np.flatnonzero(np.isfinite(table).all(1))
    table = table[whole[0] : whole[-1] + 1] if whole.size else table[:0]
    if len(table) < SHORTEST or not np.isfinite(table).all():
        raise _refused("--against", f"has {len(whole)} rows of numbers, or gaps between them", str(file),
                       f"{SHORTEST} rows at least, one after the other")
    steps = np.diff(table[:, 0])
    if not (steps > 0).all() or np.ptp(steps) > 0.02 * steps.mean():
        raise _refused("--against", f"its times ({head[0]}) are not evenly spaced", str(file),
                       "times that rise by the same step")
    if (table[:, 1:] < 0).any():
        raise _refused("--against", "has numbers below 0", str(file), "counts or densities")
    columns = {name: table[:, 1 + k] for k, name in enumerate(named.values())}
    return Outside(table[:, 0], columns, {v: k for k, v in named.items()}, head[0])


def compare(series: Series, outside: Outside, skip: float = 0.1) -> Both:
    """Describe the run after the first `skip` of it, and before a species died out, and the outside
    series."""
    names = list(outside.columns)
    n = np.stack([series.of(name) for name in names], 1)
    gone = np.flatnonzero((n == 0).any(1))
    end = int(gone[0]) if gone.size else len(n)
    n = n[min(int(skip * len(n)), end) : end]
    if len(n) < SHORTEST:
        raise _refused("DIR", f"{len(n)} ticks are left before a species died out", "",
                       "a run in which all live")
    ours = {name: n[:, k] for k, name in enumerate(names)}
    step = outside.step
    lags = {}
    for a, b in permutations(names, 2):
        if (b, a) not in lags:
            lags[a, b] = lag(ours[a], ours[b]), lag(outside.columns[a], outside.columns[b])
    return Both({name: summary(x, 1.0) for name, x in ours.items()},
                {name: summary(x, step) for name, x in outside.columns.items()}, lags)


def summary(x: np.ndarray, step: float) -> Summary:
    """Describe one series of samples so far apart."""
    logs = log_numbers(x)
    frequency, power = spectrum(logs)
    best = int(power.argmax())
    period = 1 / frequency[best]
    near = (frequency > frequency[best] / 1.6) & (frequency < frequency[best] * 1.6)
    total = float(power.sum())
    return Summary(len(x), period * step, len(x) / period, float(power[near].sum()) / total if total else 0.0,
                   float(_level(logs).std()))


def log_numbers(x: np.ndarray) -> np.ndarray:
    """log10 of numbers; what is 0 counts as half of the least above it."""
    out: np.ndarray = np.log10(np.maximum(x, x[x > 0].min() / 2)) if (x > 0).any() else np.zeros(len(x))
    return out


def spectrum(logs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [1/sample] from one and a half cycles in the series to half a cycle in a sample, and
    power: of the series without its trend, tapered by Hann's window."""
    n = len(logs)
    power = np.abs(np.fft.rfft(_level(logs) * np.hanning(n + 2)[1:-1], FINE * n)) ** 2
    frequency = np.fft.rfftfreq(FINE * n)
    some = frequency * n >= 1.5
    return frequency[some], power[some]


def lag(a: np.ndarray, b: np.ndarray) -> float:
    """How much b is behind a, a share of their common period in [0, 1): the phase of their cross-spectrum
    where both have the most power."""
    n = len(a)
    fa, fb = (np.fft.rfft(_level(log_numbers(x)) * np.hanning(n + 2)[1:-1], FINE * n) for x in (a, b))
    frequency = np.fft.rfftfreq(FINE * n)
    power = np.where(frequency * n >= 1.5, np.abs(fa) * np.abs(fb), 0.0)
    best = int(power.argmax())
    return float(np.angle(fa[best] * np.conj(fb[best])) / (2 * np.pi) % 1.0)


def _level(logs: np.ndarray) -> np.ndarray:
    """A series without its mean and its trend."""
    t = np.arange(len(logs)) - (len(logs) - 1) / 2
    flat: np.ndarray = logs - logs.mean() - t * (t @ logs) / (t @ t)
    return flat


def _rows(file: Path) -> tuple[list[str], list[list[str]]]:
    try:
        if file.stat().st_size > MOST_BYTES:
            raise OSError(f"is longer than {MOST_BYTES:,} bytes")
        rows = [row for row in csv.reader(file.read_text(encoding="utf-8-sig").splitlines()) if any(row)]
    except (OSError, ValueError, csv.Error) as error:
        raise _refused("--against", f"cannot be read: {getattr(error, 'strerror', None) or error}", str(file),
                       "a CSV file with a head") from None
    if not rows or len(rows[0]) < 2:
        raise _refused("--against", "has no head of two columns", str(file), "time, then numbers")
    head = [name.strip() for name in rows[0]]
    if short := next((i for i, row in enumerate(rows[1:], 2) if len(row) != len(head)), None):
        raise _refused("--against", f"row {short} has not as many columns as the head", str(file),
                       f"{len(head)} columns")
    return head, rows[1:]


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")


def _refused(source: str, what: str, value: str, allowed: str, near: str = "") -> ConfigError:
    return ConfigError([Problem((), what, value, allowed, near, source)])
