"""A run beside an outside series: period, amplitude and lags of both, by the same rule, however short they
are (`ecs_eco.analysis.signature`).

The tests of significance of `ecs_eco.analysis.spectrum` need 96 samples and several periods; counts from the
field are often shorter. What is said here is therefore a description, of a series as of the other, and no
test.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecs_eco.analysis.runs import Series
from ecs_eco.analysis.signature import FEWEST, cycle
from ecs_eco.analysis.spectrum import thin
from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest

KEPT = "data.csv"  # the outside series of a world, in the folder of its run
MOST_BYTES = 20_000_000
MOST_ROWS = 1000


class Place(NamedTuple):
    """Where an outside series is asked for, for messages: keys, and their source."""

    file: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    of_file: str = "--against"
    of_columns: str = "--match"


IN_WORLD = Place(("data", "file"), ("data", "columns"), "", "")


class Outside(NamedTuple):
    """An outside series: evenly spaced times f64[n], and columns f64[n] by the name of the species or
    reporter that each stands beside; `named` is what the file calls them."""

    times: np.ndarray
    columns: dict[str, np.ndarray]
    named: dict[str, str]
    unit: str  # of its time
    ticks: float | None = None  # of a run in a unit of its time, where that is known

    @property
    def step(self) -> float:
        """Time from one sample to the next."""
        return float(self.times[1] - self.times[0])


class Summary(NamedTuple):
    """One series in numbers."""

    samples: int
    period: float  # of the wave that explains most of the variance [of its time]
    cycles: float  # how many of them it holds
    share: float  # of the variance, that this wave explains
    amplitude: float  # standard deviation of the numbers on a scale of log10, trend removed


class Both(NamedTuple):
    """The summaries of one species in the run [ticks] and outside, and the lags behind other species."""

    run: dict[str, Summary]
    outside: dict[str, Summary]
    lags: dict[tuple[str, str], tuple[float, float]]  # of b behind a, shares of the period: run, outside


def outside_of(data: Mapping[str, Any], folder: Path, names: Sequence[str], source: str = "") -> Outside:
    """Read the outside series of a world, whose [data] is `data`; `names` are those of its species and
    reporters. Raises ConfigError."""
    place = IN_WORLD._replace(of_file=source, of_columns=source)
    read = read_outside(folder / data["file"], names, data.get("columns"), place, data.get("time"))
    return read._replace(unit=data.get("unit") or read.unit, ticks=data.get("ticks"))


def read_outside(file: str | Path, names: Sequence[str], match: Mapping[str, str] | None = None,
                 place: Place | None = None, time: str | None = None) -> Outside:
    """Read a CSV whose column `time`, or the first, is time; `match` gives the species or reporter, of
    `names`, that a column stands beside, where it is not named as one.

    Rows without a number in a column that is used are left out at the ends. Raises ConfigError.
    """
    place = place or Place()
    head, rows = _rows(Path(file), place)
    if time is not None and time not in head:
        raise ConfigError([Problem((*place.file[:-1], "time"), "no column of this name", time, listed(head),
                                   nearest(time, head), place.of_file)])
    time = time or head[0]
    named = _named(file, [name for name in head if name != time], names, match or {}, place)
    table = np.array([[_number(row[head.index(name)]) for name in (time, *named)] for row in rows], float)
    table = table.reshape(-1, 1 + len(named))
    whole = np.flatnonzero(np.isfinite(table).all(1))
    table = table[whole[0] : whole[-1] + 1] if whole.size else table[:0]
    faults = (
        (not FEWEST <= len(table) <= MOST_ROWS or not np.isfinite(table).all(),
         f"has {len(whole):,} rows of numbers, or gaps between them",
         f"{FEWEST} rows at least, {MOST_ROWS:,} at most, one after the other"),
        (not _even(table[:, 0]), f"its times ({time}) are not evenly spaced",
         "times that rise by the same step"),
        ((table[:, 1:] < 0).any(), "has numbers below 0", "counts or densities"),
        (not table[:, 1:].any(0).all(), "has a column of zeros alone", "counts or densities"),
    )
    for wrong, fault, allowed in faults:
        if wrong:
            raise _refused(place, fault, file, allowed)
    columns = {name: table[:, 1 + k] for k, name in enumerate(named.values())}
    return Outside(table[:, 0], columns, {v: k for k, v in named.items()}, time)


def _named(file: str | Path, head: list[str], names: Sequence[str], match: Mapping[str, str],
           place: Place) -> dict[str, str]:
    """The columns that are used, and what each stands beside."""
    named = {name: name for name in head if name in names}
    for column, name in match.items():
        for what, value, known in (("column", column, head), ("species or reporter", name, names)):
            if value not in known:
                raise ConfigError([Problem((*place.columns, *(place.columns and (column,))),
                                           f"no {what} of this name", value, listed(known),
                                           nearest(value, known), place.of_columns)])
        named = {k: v for k, v in named.items() if v != name} | {column: name}
    if not named:
        how = "[data] columns = { COLUMN = \"SPECIES\" }" if place.columns else "--match COLUMN=SPECIES"
        raise _refused(place, "no column is named as a species", file,
                       f"{how}, of columns {listed(head)} and species {listed(names)}")
    return named


def _even(times: np.ndarray) -> bool:
    steps = np.diff(times)
    return bool((steps > 0).all() and np.ptp(steps) <= 0.02 * steps.mean()) if len(steps) else True


def numbers_of(series: Series, name: str) -> np.ndarray:
    """The numbers of a species, or what a reporter measured, its mean over species: f64[ticks]."""
    if name in series.species:
        return series.of(name)
    values = series.columns[name]
    there = np.isfinite(values)
    total = np.where(there, values, 0.0).sum(1)
    return np.where(there.any(1), total / np.maximum(there.sum(1), 1), np.nan)


def compare(series: Series, outside: Outside, skip: float = 0.1) -> Both:
    """Describe the run after the first `skip` of it, and before a species died out, and the outside
    series. Raises ConfigError where too little of the run is left."""
    names = list(outside.columns)
    n = living(series, names, skip)
    thinned, factor = thin(n.T, MOST_ROWS)
    ours = dict(zip(names, thinned, strict=True))
    lags = {(a, b): (float(cycle(ours[a], ours[b]).phases[1]),
                     float(cycle(outside.columns[a], outside.columns[b]).phases[1]))
            for a, b in combinations(names, 2)}
    run = {name: summary(x, factor)._replace(samples=len(n)) for name, x in ours.items()}
    return Both(run, {name: summary(x, outside.step) for name, x in outside.columns.items()}, lags)


def living(series: Series, names: Sequence[str], skip: float = 0.1) -> np.ndarray:
    """The numbers of these species and reporters after the first `skip` of a run and before one of the
    species died out, f64[ticks, names]. Raises ConfigError where too little is left."""
    n = np.stack([numbers_of(series, name) for name in names], 1)
    species = [name in series.species for name in names]
    gone = np.flatnonzero((n[:, species] == 0).any(1))
    end = int(gone[0]) if gone.size else len(n)
    n = n[min(int(skip * len(n)), end) : end]
    wrong = [name for name, x in zip(names, n.T, strict=True)
             if not (np.isfinite(x).all() and (x >= 0).all() and x.any())]
    if len(n) >= FEWEST and wrong:
        raise ConfigError([Problem((), "is below 0, or no number, in some ticks, or always 0", wrong[0],
                                   "a reporter of counts or densities", source="DIR")])
    if len(n) < FEWEST:
        raise ConfigError([Problem((), f"{len(n)} ticks are left before a species died out", "",
                                   "a run in which all live", source="DIR")])
    return n


def summary(x: np.ndarray, step: float) -> Summary:
    """Describe one series of samples so far apart. Raises ValueError as `signature.logarithms`."""
    found = cycle(x)
    return Summary(len(x), found.period * step, len(x) / found.period, float(found.shares[0]),
                   float(found.swings[0]))


def _rows(file: Path, place: Place) -> tuple[list[str], list[list[str]]]:
    try:
        if file.stat().st_size > MOST_BYTES:
            raise OSError(f"is longer than {MOST_BYTES:,} bytes")
        rows = [row for row in csv.reader(file.read_text(encoding="utf-8-sig").splitlines()) if any(row)]
    except (OSError, ValueError, csv.Error) as error:
        fault = f"cannot be read: {getattr(error, 'strerror', None) or error}"
        raise _refused(place, fault, file, "a CSV file with a head") from None
    if not rows or len(rows[0]) < 2:
        raise _refused(place, "has no head of two columns", file, "time, then numbers")
    head = [name.strip() for name in rows[0]]
    if short := next((i for i, row in enumerate(rows[1:], 2) if len(row) != len(head)), None):
        raise _refused(place, f"row {short} has not as many columns as the head", file,
                       f"{len(head)} columns")
    return head, rows[1:]


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")


def _refused(place: Place, what: str, file: str | Path, allowed: str) -> ConfigError:
    return ConfigError([Problem(place.file, what, str(file), allowed, source=place.of_file)])
