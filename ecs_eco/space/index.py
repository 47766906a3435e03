"""The neighbor index: the living members of one table sorted by cell and, within a cell, by uid; rebuilt in
O(n)."""

from __future__ import annotations

import threading
from typing import NamedTuple

import numpy as np

from ecs_eco.compiled.jit import lone_njit, njit
from ecs_eco.space.geometry import Extent, Places, Space

NOWHERE = 2**31 - 1  # beyond all cells


class Entries(NamedTuple):
    """Members of a table sorted by cell, for kernels: entries start[c] to start[c + 1] are in cell c."""

    rows: np.ndarray  # i64[n]
    x: np.ndarray  # f32[n] [m]
    y: np.ndarray
    z: np.ndarray
    uid: np.ndarray  # u64[n]
    start: np.ndarray  # i64[cells + 1]


class Index:
    """The living members of a table sorted by cell, for neighbor queries.

    Attributes
    ----------
    n : int
    rows : array of int64, shape (n,)
    x : array of float32, shape (n,)
        Coordinates [m]; `y` and `z` hold the other two.
    start : array of int64, shape (cells + 1,)
        Cell c contains the entries start[c] to start[c + 1].

    Notes
    -----
    The order of entries depends only on positions and uids. It is the canonical order for sums and ties, so
    results do not depend on the order of rows.
    """

    def __init__(self, space: Space) -> None:
        self.space = space
        self.version = -1
        self.flat = True
        self.lock = threading.Lock()  # held by the thread that builds the index
        self._allocate(0)

    def _allocate(self, n: int) -> None:
        self.start = np.zeros(self.space.n_cells + 1, np.int64)
        self._cell = np.full(n, NOWHERE, np.int32)
        x, y, z = (np.empty(n, np.float32) for _ in range(3))
        self._all = Entries(np.empty(n, np.int64), x, y, z, np.empty(n, np.uint64), self.start)

    def build(self, alive: np.ndarray, x: np.ndarray, y: np.ndarray, z: np.ndarray, uid: np.ndarray) -> None:
        """Sort the rows that are `alive` bool[rows]; the other arrays must be at least as long. Positions
        outside [0, size) are assigned to the nearest cell."""
        if alive.size > self._cell.size:
            self._allocate(max(alive.size + alive.size // 4, 2 * self._cell.size))  # spare rows for newborns
        if self.start.size != self.space.n_cells + 1:
            self._allocate(self._cell.size)
        self.flat = sort_cells(alive, Places(x, y, z), uid, self.space.extent, self._cell, self._all)
        self.n = n = int(self.start[-1])
        rows, x, y, z, uid, _ = self._all
        self.entries = Entries(rows[:n], x[:n], y[:n], z[:n], uid[:n], self.start)
        self.rows, self.x, self.y, self.z, self.uid, _ = self.entries


@njit
def sort_cells(
    alive: np.ndarray, places: Places, uid: np.ndarray, space: Extent, cell: np.ndarray, into: Entries
) -> bool:
    """Sort the living rows by cell (counting sort, with x varying fastest), then by uid within a cell
    (insertion sort). Return whether z is 0 everywhere.

    Dead rows are sorted too, after the last cell, because a branch per row would take longer.
    """
    (x, y, z), (rows, sx, sy, sz, su, start) = places, into
    n_cells = space.nx * space.ny * space.nz
    find_cells(alive, x, y, z, space, cell)
    start[:] = 0
    for row in range(alive.size):
        start[np.uint32(cell[row])] += 1
    total = 0
    for c in range(n_cells + 1):
        begin = total
        total += start[c]
        start[c] = begin
    for row in range(alive.size):
        of = np.uint32(cell[row])
        place = np.uint64(start[of])
        start[of] += 1
        rows[place] = row
        su[place] = uid[row]
    for c in range(n_cells, 0, -1):
        start[c] = start[c - 1]
    start[0] = 0
    for i in range(1, start[n_cells]):
        this, before = np.uint64(i), np.uint64(i - 1)
        if (su[before] > su[this]) & (cell[rows[before]] == cell[rows[this]]):
            insert(i, cell, rows, su)
    high = 0
    for i in range(start[n_cells]):
        it = np.uint64(rows[i])
        sx[i], sy[i], sz[i] = x[it], y[it], z[it]
        high |= z[it] != np.float32(0.0)
    return high == 0


@njit
def insert(i, cell, rows, su):
    """Move entry i of a cell to its position by uid among the entries before it."""
    u, row, j = su[i], rows[i], i
    while j > 0 and su[j - 1] > u and cell[rows[j - 1]] == cell[row]:
        su[j] = su[j - 1]
        rows[j] = rows[j - 1]
        j -= 1
    su[j] = u
    rows[j] = row


@lone_njit
def find_cells(alive, x, y, z, space, cell):
    """Write the cell i32[rows] of each living row, as in `cell_of`; dead rows get the number of cells.

    Branch-free, so that it vectorizes.
    """
    nx, ny, nz, inverse = np.int32(space.nx), np.int32(space.ny), np.int32(space.nz), space.inverse
    zero, one = np.float32(0.0), np.int32(1)
    fx, fy, fz, ix, iy, iz = (
        np.float32(nx),
        np.float32(ny),
        np.float32(nz),
        inverse[0],
        inverse[1],
        inverse[2],
    )
    for k in range(alive.size):
        row = np.uint64(k)
        px, py, pz = x[row] * ix, y[row] * iy, z[row] * iz
        px, py, pz = px if px > zero else zero, py if py > zero else zero, pz if pz > zero else zero
        px, py, pz = px if px < fx else fx, py if py < fy else fy, pz if pz < fz else fz
        cx, cy, cz = min(np.int32(px), nx - one), min(np.int32(py), ny - one), min(np.int32(pz), nz - one)
        cell[row] = (cz * ny + cy) * nx + cx if alive[row] else nx * ny * nz
