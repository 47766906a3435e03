"""Effects of land cover on organisms: maps of growth, pace, cost and shelter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ecs_eco.space.geometry import cells_of

Value = Callable[[Any], float]


class LandMaps:
    """Maps f32[ny, nx] of the land classes' factors for growth, pace and cost (None: all are 1), and of their
    share of `shelter` (None: all are 0). `wet` bool[ny, nx] marks streams; `sha256` identifies the land."""

    def __init__(self, land: Any, classes: Sequence[Any]) -> None:
        self.kinds, self.sha256 = land.kinds, land.sha256
        self.colors: list[str | None] = [c.color for c in classes]
        self.grounds: list[str] = [c.ground for c in classes]
        self.growth = _map(land.kinds, classes, lambda c: c.growth, 1.0)
        self.pace = _map(land.kinds, classes, lambda c: c.pace, 1.0)
        self.cost = _map(land.kinds, classes, lambda c: c.cost, 1.0)
        self.shelter = _map(land.kinds, classes, lambda c: c.shelter, 0.0)
        self.wet: np.ndarray | None = None


def _map(kinds: np.ndarray, classes: Sequence[Any], value: Value, usual: float) -> np.ndarray | None:
    values = np.array([usual, *map(value, classes)], np.float32)
    return None if (values == np.float32(usual)).all() else values[kinds]


def at_places(factors: np.ndarray, terrain: Any, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the values f32[n] of a terrain's map f32[ny, nx] at positions f32[n] [m]."""
    out: np.ndarray = factors[
        cells_of(y, terrain.inverse[1], terrain.shape[0]), cells_of(x, terrain.inverse[0], terrain.shape[1])
    ]
    return out
