"""Curves of a world over time, as the message "series": levels at each tick, and totals up to that tick."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

MOST = 4000  # maximum number of points
DEPTH = "mean depth [m]"  # a chart next to the reports; no reporter can have this name
Key = tuple[str, ...]
"""The name of a curve: group and name, plus an inner name in nested groups: ("n", "deer"), ("reports",
reporter, species or ""), ("light", "")."""


class Point(NamedTuple):
    """One point of each curve."""

    tick: int
    levels: dict[Key, float]  # values at this tick
    sums: dict[Key, float]  # totals up to this tick; their curves show the increase per tick


class Curves:
    """Points by tick. When there are `most` points, every second point is dropped."""

    def __init__(self, most: int = MOST) -> None:
        self.most = most
        self.points: list[Point] = []

    @property
    def ticks(self) -> list[int]:
        """The tick of each point."""
        return [point.tick for point in self.points]

    def add(self, point: Point) -> None:
        """Append a point."""
        if len(self.points) >= self.most:
            del self.points[1::2]
        self.points.append(point)

    def cut(self, tick: int) -> None:
        """Drop the points from this tick onward."""
        while self.points and self.points[-1].tick >= tick:
            del self.points[-1]

    def after(self, tick: int) -> dict[str, Any] | None:
        """Return the points after a tick as a message, or None if there are none."""
        first = len(self.points)
        while first and self.points[first - 1].tick > tick:
            first -= 1
        if first == len(self.points):
            return None
        before = min(first, 1)  # the first rate needs the previous point
        points = self.points[first - before :]
        return series(
            np.array([point.tick for point in points]),
            _columns((point.levels for point in points[before:]), math.nan),
            _columns((point.sums for point in points), 0.0),
            before,
        )


def _columns(points: Iterable[Mapping[Key, float]], missing: float) -> dict[Key, np.ndarray]:
    held = list(points)
    names = dict.fromkeys(key for point in held for key in point)
    return {key: np.array([point.get(key, missing) for point in held], float) for key in names}


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
