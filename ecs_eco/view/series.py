"""The curves of a watched world: points noted now and then, thinned when there are many."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

MOST = 4000  # points


class Curves:
    """Points by tick, each a flat dict of numbers; a name that a point lacks is null there."""

    def __init__(self, most: int = MOST) -> None:
        self.most, self.every = most, 1
        self.ticks: list[int] = []
        self.points: list[dict[tuple[str, ...], float]] = []

    def add(self, tick: int, point: dict[tuple[str, ...], float]) -> None:
        """Add a point {(group, name): number}, of what reporters say {("reports", reporter, species or ""):
        number}; when there are `most`, every second one is dropped."""
        if len(self.ticks) >= self.most:
            del self.ticks[1::2], self.points[1::2]
        self.ticks.append(tick)
        self.points.append(point)

    def cut(self, tick: int) -> None:
        """Forget the points of a tick and of later ones."""
        while self.ticks and self.ticks[-1] >= tick:
            del self.ticks[-1], self.points[-1]

    def after(self, tick: int) -> dict[str, Any] | None:
        """Return the points of later ticks as a message; None where there are none."""
        first = len(self.ticks)
        while first and self.ticks[first - 1] > tick:
            first -= 1
        if first == len(self.ticks):
            return None
        points = self.points[first:]
        out: dict[str, Any] = {
            "kind": "series",
            "tick": self.ticks[first:],
            "n": {},
            "happiness": {},
            "genes": {},
        }
        for key in dict.fromkeys(key for point in points for key in point):
            values = [_plain(point.get(key)) for point in points]
            group, name, *species = key
            if species:
                out.setdefault(group, {}).setdefault(name, {})[species[0]] = values
            elif name:
                out.setdefault(group, {})[name] = values
            else:
                out[group] = values
        return out


def _plain(value: float | None) -> float | None:
    if value is None or not math.isfinite(value):
        return None
    return value if isinstance(value, int) else float(f"{value:.6g}")


def by_species(said: dict[str, Any]) -> dict[str, list[float | None]]:
    """Return what a reporter said by species, or by "" where all have the same number, the world's."""
    first, *others = said.values()
    if all(np.array_equal(first, other, equal_nan=True) for other in others):
        said = {"": first}
    return {
        name: [_plain(float(v)) for v in values] for name, values in said.items() if np.isfinite(values).any()
    }
