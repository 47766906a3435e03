"""Curves of a world over time: what is at a tick, and what has happened until then, as the message "series"."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

MOST = 4000  # points
DEPTH = "mean depth [m]"  # a chart beside those of reporters, which cannot be called so
Key = tuple[str, ...]
"""The name of a curve: group and name, and for groups of groups the name within it: ("n", "deer"), ("reports",
reporter, species or ""), ("light", "")."""


class Point(NamedTuple):
    """A point of all curves."""

    tick: int
    levels: dict[Key, float]  # what is at this tick
    sums: dict[Key, float]  # what has happened until then; its curve is what happened in a tick


class Curves:
    """Points by tick; when there are `most`, every second one is dropped."""

    def __init__(self, most: int = MOST) -> None:
        self.most = most
        self.points: list[Point] = []

    @property
    def ticks(self) -> list[int]:
        """The ticks of the points."""
        return [point.tick for point in self.points]

    def add(self, point: Point) -> None:
        """Add a point."""
        if len(self.points) >= self.most:
            del self.points[1::2]
        self.points.append(point)

    def cut(self, tick: int) -> None:
        """Forget the points of a tick and of later ones."""
        while self.points and self.points[-1].tick >= tick:
            del self.points[-1]

    def after(self, tick: int) -> dict[str, Any] | None:
        """Return the points of later ticks as a message; None where there are none."""
        first = len(self.points)
        while first and self.points[first - 1].tick > tick:
            first -= 1
        if first == len(self.points):
            return None
        before = min(first, 1)  # the point from which the first rate is
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
    """Return the message "series" of these ticks i64[n].

    Levels f64[n] are shown as they are, sums f64[n] as what was added a tick since the tick before; NaN is
    null. The first `before` ticks, 0 or 1, are only there for these rates, and have no levels.
    """
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
    """Return a number as short as a chart needs it."""
    if not math.isfinite(value):
        return None
    return int(value) if value.is_integer() and abs(value) < 1e15 else float(f"{value:.6g}")


def died(s: str, causes: Iterable[tuple[str, Any]], born: float | np.ndarray) -> dict[Key, Any]:
    """Return sums of the births and deaths of a species, all in all and by cause."""
    by_cause = dict(causes)
    return {
        ("births", s): born,
        ("deaths", s): sum(by_cause.values(), start=0.0 * born),
        **{("causes", s, cause): n for cause, n in by_cause.items()},
    }
