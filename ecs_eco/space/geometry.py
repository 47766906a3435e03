"""The extent of a world, its edges, and the cells of its neighbor index."""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from ecs_eco.compiled.jit import lone_njit, njit

BLOCK = 128  # positions whose cells are computed together


class Extent(NamedTuple):
    """Extent of a space, for kernels: the cells of its neighbor index, its side lengths and its edges."""

    nx: int  # cells along x, y and z
    ny: int
    nz: int
    inverse: np.ndarray  # f32[3], cells per meter
    lengths: np.ndarray  # f32[3] [m]
    torus: bool
    volume: bool


class Places(NamedTuple):
    """Positions, for kernels: f32[n] [m]."""

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray


class Space:
    """A plane or a volume whose edges wrap around or are walls; a volume always has walls at the bottom and
    the top.

    Parameters
    ----------
    size : sequence of float
        Extent along each axis [m], two or three numbers.
    edges : {"torus", "walls"}
    cell : float, optional
        Desired side length of the cells of the neighbor index [m]; cells may be slightly larger so that a
        whole number fits.

    Raises
    ------
    ValueError
        If the size or the edges are invalid.

    Examples
    --------
    >>> from ecs_eco.space import Space
    >>> Space((20.0, 10.0, 5.0), edges="walls").volume
    True
    """

    def __init__(self, size: Sequence[float], edges: str = "torus", cell: float | None = None) -> None:
        if len(size) not in (2, 3) or not all(math.isfinite(s) and s > 0 for s in size):
            raise ValueError(f"space.size is {list(size)}; it must be two or three positive numbers [m]")
        if edges not in ("torus", "walls"):
            raise ValueError(f"space.edges is {edges!r}; it must be 'torus' or 'walls'")
        self.size = tuple(float(s) for s in size)
        self.edges = edges
        self.torus = edges == "torus"
        self.lengths = np.array([*self.size, 0.0][:3], np.float32)  # z is 0 on a plane
        self.wrap = (self.torus, self.torus, False)
        self.volume = len(self.size) == 3  # whether the space has a third dimension
        self.set_cell(cell if cell is not None else max(min(self.size[:2]) / 32, 1e-3))

    def set_cell(self, cell: float) -> None:
        """Set the side length of the index cells [m]; there are at most 4 million cells."""
        if not cell > 0:
            raise ValueError(f"space.cell is {cell}; it must be a positive length [m]")
        # a smaller cell would not grow in the loop below, and the number of cells would overflow
        cell = max(cell, 1e-300)
        # in floats, because numpy integers wrap around
        while math.prod(max(1.0, min(s / cell, 1e18) // 1) for s in self.size) > 4_000_000:
            cell *= 1.25
        self.cell = float(cell)
        n = [max(1, int(s / cell)) for s in self.size] + [1]
        self.shape = (n[0], n[1], n[2] if self.volume else 1)  # cells along x, y, z
        self.inverse = np.array(
            [n[0] / self.size[0], n[1] / self.size[1], n[2] / self.size[2] if self.volume else 0.0],
            np.float32,
        )
        self.n_cells = self.shape[0] * self.shape[1] * self.shape[2]
        self.extent = Extent(*self.shape, self.inverse, self.lengths, self.torus, self.volume)
        side = min(s / n for s, n in zip(self.size, self.shape, strict=False))  # the shortest side of a cell
        # cells that a search radius [m] spans on each side; cached, because the same few radii recur
        self.reach: Callable[[float], int] = lru_cache(256)(partial(cells_within, side, max(self.shape)))


def cells_within(side: float, most: int, radius: float) -> int:
    """Return how many cells with this side length [m] a radius [m] spans, at most `most`; 0 for NaN."""
    cells = radius / side
    return max(math.ceil(cells - 1e-6), 0) if cells < most else most * (cells >= most)


@njit
def wrapped(d, length):
    """Return the shortest difference equivalent to d on a ring of this length."""
    return d - length * np.float32(np.floor(d / length + np.float32(0.5)))


def back_into(v: np.ndarray, length: float, torus: bool) -> np.ndarray:
    """Return coordinates wrapped around a torus, or clipped at the walls.

    Parameters
    ----------
    v : array of float32, shape (n,)
        Coordinates along one axis [m].
    length : float
        Extent of the axis [m].
    torus : bool

    Returns
    -------
    array of float32, shape (n,)
        In [0, length).

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.space.geometry import back_into
    >>> back_into(np.array([-1.0, 3.0], np.float32), 10.0, torus=True).tolist()
    [9.0, 3.0]
    """
    near = np.nextafter(np.float32(length), np.float32(0.0))
    return np.minimum(v % length, near) if torus else v.clip(0, near)


@njit
def into(v, length, torus):
    """Return a coordinate wrapped into [0, length) on a torus, or clipped at the walls; 0 for NaN."""
    zero = np.float32(0.0)
    if torus:
        v = v - length * np.float32(np.floor(v / length))
        return v if zero <= v < length else zero
    v = v if v > zero else zero
    return min(v, np.nextafter(length, zero))


@njit
def cell_of(place, n):
    """Return which of n cells contains a coordinate given in units of cells; the nearest cell if it lies
    outside, 0 for NaN."""
    zero, end = np.float32(0.0), np.float32(n)
    place = place if place > zero else zero
    place = place if place < end else end
    return min(int(place), n - 1)


@lone_njit
def cells_at(first, size, places, shape, inverse, cell):
    """Write the cell index of each of `size` positions, starting at `first`, to cell i32[BLOCK], with x
    varying fastest, as in `cell_of`; `shape` is (nz, ny, nx). Branch-free, so that it vectorizes."""
    (x, y, z), (nz, ny, nx) = places, shape
    ix, iy, iz = inverse[0], inverse[1], inverse[2]
    zero, one, nx, ny, nz = np.float32(0.0), np.int32(1), np.int32(nx), np.int32(ny), np.int32(nz)
    fx, fy, fz = np.float32(nx), np.float32(ny), np.float32(nz)
    for k in range(size):
        i = np.uint64(first + k)
        px, py, pz = x[i] * ix, y[i] * iy, z[i] * iz
        px, py, pz = px if px > zero else zero, py if py > zero else zero, pz if pz > zero else zero
        px, py, pz = px if px < fx else fx, py if py < fy else fy, pz if pz < fz else fz
        cx, cy, cz = min(np.int32(px), nx - one), min(np.int32(py), ny - one), min(np.int32(pz), nz - one)
        cell[np.uint64(k)] = (cz * ny + cy) * nx + cx


@njit
def floor_between(place, low, high):
    """Return the floor of a coordinate in units of cells, at least low and at most high; low for NaN."""
    least, most = np.float32(low), np.float32(high)
    place = place if place > least else least
    place = place if place < most else most
    return min(int(np.floor(place)), high)


@njit
def half_cells(way, inverse, lengths):
    """Return the length of a path [m] in units of half a map cell, at most the sum of the space's length and
    width."""
    each = max(inverse[0], inverse[1]) * np.float32(2.0)
    n, most = np.ceil(way * each), np.ceil((lengths[0] + lengths[1]) * each)
    n = n if n > np.float32(0.0) else np.float32(0.0)
    return int(n if n < most else most)


def cells_of(v: np.ndarray, inverse: float, n: int) -> np.ndarray:
    """Return which of n cells, `inverse` per meter, contains each coordinate f32[k] [m], as in `cell_of`:
    i64[k]."""
    return np.nan_to_num(v * inverse, nan=0.0, posinf=n, neginf=0.0).clip(0, n - 1).astype(np.int64)
