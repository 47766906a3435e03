"""The edges between bands: which band owns each row of cells, and which rows are near each band."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ecs_eco.space.geometry import Space


class Edges:
    """Bands of whole rows of cells, from y = 0 upward: band k has rows `rows[k]` … `rows[k + 1]` − 1.

    Each band is at least `least` rows high. `owner` i64[ny] is the band of each row.
    """

    def __init__(self, space: Space, size: int, least: int) -> None:
        self.space, self.size, self.least, self.ny = space, size, least, space.shape[1]
        self.move(self.even(np.ones(self.ny)))

    def move(self, rows: np.ndarray) -> None:
        """Set the first row of each band: i64[size + 1]."""
        self.rows = rows
        self.owner = np.repeat(np.arange(self.size), np.diff(rows))
        self._near: dict[tuple[int, int], dict[int, np.ndarray]] = {}

    def even(self, weights: np.ndarray) -> np.ndarray:
        """Return the first rows i64[size + 1] of bands whose weights f64[ny] have about equal sums."""
        sums = np.concatenate([[0.0], np.cumsum(weights)])
        aims = sums[-1] * np.arange(1, self.size) / self.size
        rows = [0]
        for k, aim in enumerate(aims, 1):
            at = int(np.searchsorted(sums, aim))
            at -= int(at > 0 and aim - sums[at - 1] < sums[at] - aim)
            rows.append(min(max(at, rows[-1] + self.least), self.ny - (self.size - k) * self.least))
        return np.array([*rows, self.ny])

    def uneven(self, weights: np.ndarray) -> float:
        """Return the weight of the heaviest band, relative to the mean."""
        each = np.add.reduceat(weights, self.rows[:-1])
        return float(each.max() / max(each.mean(), 1e-300))

    def row_of(self, y: np.ndarray) -> np.ndarray:
        """Return the row of cells of each position y f32[n] [m], as in the neighbor index: i64[n]."""
        return (y * self.space.inverse[1]).astype(np.int64).clip(0, self.ny - 1)

    def owner_of(self, y: np.ndarray) -> np.ndarray:
        """Return the band of each position y f32[n] [m]: i64[n]."""
        return self.owner[self.row_of(y)]

    def near(self, rank: int, width: int) -> dict[int, np.ndarray]:
        """Return a mask bool[ny] for each neighboring band: the rows of band `rank` that are at most `width`
        rows beyond the neighbor's edges."""
        if (rank, width) not in self._near:
            mine, out = self.owner == rank, {}
            for other in range(self.size):
                rows = beyond(self.rows[other], self.rows[other + 1], self.ny, width, self.space.torus) & mine
                if other != rank and rows.any():
                    out[other] = rows
            self._near[rank, width] = out
        return self._near[rank, width]


def beyond(first: int | np.integer, last: int | np.integer, n: int, width: int, torus: bool) -> np.ndarray:
    """Return a mask bool[n] of the rows outside first … last − 1 but at most `width` rows away."""
    rows = np.concatenate([np.arange(first - width, first), np.arange(last, last + width)])
    rows = rows % n if torus else rows[(rows >= 0) & (rows < n)]
    out = np.zeros(n, np.bool_)
    out[rows] = True
    out[first:last] = False
    return out
