"""Curves of a world over time, as the message "series": levels at each tick, and totals up to that tick."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

MOST = 4000  # maximum number of points
DEPTH = "mean depth [m]"  # a chart next to the reports; no reporter can have this name
Key = tuple[str, ...]
"""The name of a curve: group and name, plus an inner name in nested groups: ("n", "deer"), ("reports",
reporter, species or ""), ("light", "")."""


class Curves:
    """The points of curves, at increasing ticks: levels, and sums over all ticks up to the point.

    When there are more than `most` points, half of them remain, with the extremes of all populations. `first`
    is the earliest tick that may have a point.
    """

    def __init__(self, most: int = MOST) -> None:
        self.most, self.first = most, 0
        self.ticks = np.zeros(0, np.int64)
        self._levels: dict[Key, np.ndarray] = {}
        self._sums: dict[Key, np.ndarray] = {}
        self._first: dict[Key, int] = {}  # tick of the first points that have this curve

    @property
    def last(self) -> int:
        """The tick of the last point; −1 if there is none."""
        return int(self.ticks[-1]) if self.ticks.size else -1

    def add(
        self, ticks: np.ndarray, levels: Mapping[Key, np.ndarray], gains: Mapping[Key, np.ndarray]
    ) -> None:
        """Append points at ticks i64[k]: levels f64[k], and how much each sum has grown since the last point,
        f64[k]."""
        self._first = {key: int(ticks[0]) for key in (*levels, *gains)} | self._first
        unknown, k = np.full(self.ticks.size, math.nan), len(ticks)
        for key in dict.fromkeys((*self._levels, *levels)):
            new = levels[key] if key in levels else np.full(k, math.nan)
            self._levels[key] = np.append(self._levels.get(key, unknown), new)
        for key in dict.fromkeys((*self._sums, *gains)):
            new = self.total(key) + (gains[key] if key in gains else np.zeros(k))
            self._sums[key] = np.append(self._sums.get(key, 0 * self.ticks), new)
        self.ticks = np.append(self.ticks, ticks)
        if self.ticks.size > self.most:
            self._keep(extremes(self._populations(), self.most // 2))

    def cut(self, tick: int) -> None:
        """Drop the points from this tick onward."""
        self._keep(np.arange(np.searchsorted(self.ticks, tick)))
        for key in [key for key, first in self._first.items() if first >= tick]:
            for held in (self._first, self._levels, self._sums):
                held.pop(key, None)

    def total(self, key: Key) -> float:
        """Return a sum at the last point, 0 if it is unknown."""
        return float(self._sums[key][-1]) if key in self._sums and self.ticks.size else 0.0

    def after(self, tick: int) -> dict[str, Any] | None:
        """Return the points after a tick as a message, or None if there are none."""
        first = int(np.searchsorted(self.ticks, tick, side="right"))
        if first == self.ticks.size:
            return None
        before = min(first, 1)  # the first rate needs the previous point
        levels = {key: of[first:] for key, of in self._levels.items() if not np.isnan(of[first:]).all()}
        sums = {key: of[first - before :] for key, of in self._sums.items()}
        return series(self.ticks[first - before :], levels, sums, before)

    def _populations(self) -> np.ndarray:
        """Return the population sizes f64[species, points]."""
        return np.array([of for (group, *_), of in self._levels.items() if group == "n"])

    def _keep(self, points: np.ndarray) -> None:
        self.ticks = self.ticks[points]
        for held in (self._levels, self._sums):
            for key, of in held.items():
                held[key] = of[points]


def extremes(n: np.ndarray, most: int) -> np.ndarray:
    """Return about `most` points to keep, i64 in order: of equal stretches, those in which a population
    n f64[species, points] is lowest and highest, and the first and last point.

    At least one stretch with its two points per species is kept.
    """
    points = n.shape[1]
    edges = np.linspace(0, points, max(1, (most - 2) // (2 * len(n))) + 1).astype(np.int64)
    kept = [0, points - 1]
    for begin, end in pairwise(edges.tolist()):
        part = np.nan_to_num(n[:, begin:end])
        kept += [*(begin + part.argmin(axis=1)), *(begin + part.argmax(axis=1))] if begin < end else []
    return np.unique(kept)


def series(
    tick: np.ndarray, levels: Mapping[Key, np.ndarray], sums: Mapping[Key, np.ndarray], before: int = 0
) -> dict[str, Any]:
    """Return the message "series" for these ticks i64[n].

    Levels f64[n] are sent unchanged; sums f64[n] are sent as the mean increase per tick since the previous
    point; NaN becomes null. The first `before` points (0 or 1) are used only to compute rates and have no
    levels."""
    span = np.diff(tick)
    rates = {key: np.append(np.nan, np.diff(of) / span)[before:] for key, of in sums.items()}
    out: dict[str, Any] = {"kind": "series", "tick": tick[before:].tolist(), "n": {}, "happiness": {}}
    out["genes"] = {}
    for (group, name, *within), values in (dict(levels) | rates).items():
        shown = [_plain(value) for value in values.tolist()]
        if within:
            out.setdefault(group, {}).setdefault(name, {})[within[0]] = shown
        elif name:
            out.setdefault(group, {})[name] = shown
        else:
            out[group] = shown
    return out


def _plain(value: float) -> float | None:
    """Return a number rounded to the digits that a chart needs."""
    if not math.isfinite(value):
        return None
    return int(value) if value.is_integer() and abs(value) < 1e15 else float(f"{value:.6g}")


def died(s: str, causes: Iterable[tuple[str, Any]], born: float | np.ndarray) -> dict[Key, Any]:
    """Return the cumulative births and deaths of a species, with deaths also by cause."""
    by_cause = dict(causes)
    return {
        ("births", s): born,
        ("deaths", s): sum(by_cause.values(), start=0.0 * born),
        **{("causes", s, cause): n for cause, n in by_cause.items()},
    }
