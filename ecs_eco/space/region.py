"""Regions of the ground: circles and rectangles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ecs_eco.compiled.elementary import arrays
from ecs_eco.space.geometry import Space

CORNERS = 64  # number of corners that approximate a circle's border


class Region:
    """A circle [x, y, radius], which may wrap around a torus, or a rectangle [x0, y0, x1, y1] on the ground
    [m]."""

    def __init__(self, space: Space | None, numbers: Sequence[float]) -> None:
        self.space: Any = space  # None if only the region's border is needed
        self.numbers, self.round = [float(v) for v in numbers], len(numbers) == 3

    def has(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return whether each position is in the region: bool[n]."""
        if not self.round:
            x0, y0, x1, y1 = self.numbers
            return (x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)
        away = [np.asarray(v, float) - centre for v, centre in zip((x, y), self.numbers, strict=False)]
        if self.space.torus:
            away = [d - size * np.round(d / size) for d, size in zip(away, self.space.size, strict=False)]
        return arrays.hypot(*away) <= self.numbers[2]

    def places(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Map pairs of numbers in [0, 1) to positions f32[n, 2] in the region, uniformly over its area."""
        if self.round:
            x, y, radius = self.numbers
            r, angle = radius * np.sqrt(u), 2 * np.pi * v
            place = np.stack([x + r * arrays.cos(angle), y + r * arrays.sin(angle)], 1)
        else:
            x0, y0, x1, y1 = self.numbers
            place = np.stack([x0 + u * (x1 - x0), y0 + v * (y1 - y0)], 1)
        size = np.array(self.space.size[:2])
        place = place % size if self.space.torus else place.clip(0, size)
        return np.minimum(place.astype(np.float32), np.nextafter(self.space.lengths[:2], np.float32(0)))

    def border(self) -> np.ndarray:
        """Return the corners of the border, with the first one repeated at the end: f64[k, 2]."""
        if not self.round:
            x0, y0, x1, y1 = self.numbers
            return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]])
        x, y, radius = self.numbers
        angle = 2 * np.pi * (np.arange(CORNERS + 1) % CORNERS) / CORNERS
        return np.stack([x + radius * arrays.cos(angle), y + radius * arrays.sin(angle)], 1)
