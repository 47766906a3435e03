"""A height map with slopes that cost and cells that nothing walks into: lakes, rocks, steep mountains."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ecs_eco import random
from ecs_eco._numba import njit
from ecs_eco.space.geometry import Space

OPEN, WATER, ROCK = 0, 1, 2


class Terrain:
    """Heights f32[ny, nx] [m] and ground u8[ny, nx] (0 open, 1 water, 2 rock) on cells of side `cell` [m].

    Water stops walkers, rock stops walkers and sight. `slope_cost` is the extra cost of locomotion per unit of upward
    slope, as a share of the cost on the flat.
    """

    def __init__(self, space: Space, cell: float = 1.0, *, hills: Mapping[str, float] | None = None,
                 mountains: Sequence[Mapping[str, Any]] = (), rocks: Sequence[Mapping[str, Any]] = (),
                 lakes: Sequence[Mapping[str, Any]] = (), slope_cost: float = 1.0) -> None:
        nx, ny = max(1, round(space.size[0] / cell)), max(1, round(space.size[1] / cell))
        self.space, self.slope_cost = space, float(slope_cost)
        self.height = np.zeros((ny, nx), np.float32)
        self.ground = np.zeros((ny, nx), np.uint8)
        self.inverse = np.array([nx / space.size[0], ny / space.size[1]], np.float32)
        if hills:
            self.height += _hills(space, nx, ny, **hills)
        for mountain in mountains:
            share = self._closeness(mountain)
            self.height += (np.float32(mountain.get("height", 10.0)) * share * share * (3 - 2 * share)).astype(np.float32)
        for kind, places in ((ROCK, rocks), (WATER, lakes)):
            for place in places:
                self.ground[self._closeness(place) > 0] = kind

    def _closeness(self, place: Mapping[str, Any]) -> np.ndarray:
        """Return 1 at the centre of a round place, 0 at its radius and beyond: f64[ny, nx]."""
        ny, nx = self.height.shape
        x = (np.arange(nx) + 0.5) / self.inverse[0] - place["at"][0]
        y = (np.arange(ny) + 0.5) / self.inverse[1] - place["at"][1]
        if self.space.torus:
            x -= self.space.size[0] * np.round(x / self.space.size[0])
            y -= self.space.size[1] * np.round(y / self.space.size[1])
        return np.clip(1 - np.hypot(x[None, :], y[:, None]) / place["radius"], 0, 1)

    def free(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return whether each place [m] is open ground: bool[n]."""
        i = np.minimum((x * self.inverse[0]).astype(int), self.ground.shape[1] - 1)
        j = np.minimum((y * self.inverse[1]).astype(int), self.ground.shape[0] - 1)
        return self.ground[j, i] == OPEN


def _hills(space: Space, nx: int, ny: int, seed: float = 0, amplitude: float = 5.0, scale: float = 30.0) -> np.ndarray:
    """Return smooth hills: a sum of 32 plane waves of random direction and phase that close around the torus."""
    u = random.draw_many(random.tick_key(int(seed), 0), np.arange(96, dtype=np.uint64), random.PLACE).reshape(3, 32)
    x, y = (np.arange(nx) + 0.5) / nx, (np.arange(ny) + 0.5) / ny
    height = np.zeros((ny, nx))
    for angle, phase, stretch in u.T:
        waves = (0.5 + stretch) * np.array(space.size[:2]) / scale
        kx, ky = np.round(waves[0] * np.cos(2 * np.pi * angle)), np.round(waves[1] * np.sin(2 * np.pi * angle))
        height += np.sin(2 * np.pi * (kx * x[None, :] + ky * y[:, None] + phase))
    return (amplitude * height / np.sqrt(16)).astype(np.float32)


@njit
def ground_at(ground, inverse, x, y):
    """Return the kind of ground at a place."""
    return ground[min(int(y * inverse[1]), ground.shape[0] - 1), min(int(x * inverse[0]), ground.shape[1] - 1)]


@njit
def height_at(height, inverse, x, y, torus):
    """Return the height [m] at a place, linear between the centres of cells."""
    ny, nx = height.shape
    gx, gy = x * inverse[0] - np.float32(0.5), y * inverse[1] - np.float32(0.5)
    i0, j0 = int(np.floor(gx)), int(np.floor(gy))
    fx, fy = gx - np.float32(i0), gy - np.float32(j0)
    i1, j1 = i0 + 1, j0 + 1
    if torus:
        i0, i1, j0, j1 = i0 % nx, i1 % nx, j0 % ny, j1 % ny
    else:
        i0, i1, j0, j1 = min(max(i0, 0), nx - 1), min(max(i1, 0), nx - 1), min(max(j0, 0), ny - 1), min(max(j1, 0), ny - 1)
    one = np.float32(1.0)
    west = (one - fy) * height[j0, i0] + fy * height[j1, i0]
    east = (one - fy) * height[j0, i1] + fy * height[j1, i1]
    return (one - fx) * west + fx * east
