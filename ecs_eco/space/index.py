"""The neighbour index: the living of one table sorted by cell, within a cell by uid; rebuilt in O(n)."""

import threading

import numpy as np

from ecs_eco.engine.jit import njit
from ecs_eco.space.geometry import Space, cell_of


class Index:
    """The living sorted by place.

    Entry i is row `rows[i]`, at (x[i], y[i], z[i]) [m]; cell c holds entries start[c] to start[c+1]. The
    order of the entries follows from places and uids alone: it is the canonical order of all sums and ties.
    """

    def __init__(self, space: Space) -> None:
        self.space = space
        self.version = -1
        self.lock = threading.Lock()  # held by the thread that builds it
        self.start = np.zeros(space.n_cells + 1, np.int64)
        self._allocate(0)

    def _allocate(self, n: int) -> None:
        self._cell = np.empty(n, np.int32)
        self._rows = np.empty(n, np.int64)
        self._x, self._y, self._z = (np.empty(n, np.float32) for _ in range(3))
        self._uid = np.empty(n, np.uint64)

    def build(self, alive: np.ndarray, x: np.ndarray, y: np.ndarray, z: np.ndarray, uid: np.ndarray) -> None:
        """Sort the rows that are alive; all arrays are [rows], places in [0, size):
        others count as in the nearest cell."""
        if alive.size > self._cell.size:
            self._allocate(max(alive.size, 2 * self._cell.size))
        if self.start.size != self.space.n_cells + 1:
            self.start = np.zeros(self.space.n_cells + 1, np.int64)
        nx, ny, nz = self.space.shape
        sort_cells(alive, x, y, z, uid, nx, ny, nz, self.space.inverse, self._cell, self.start,
                   self._rows, self._x, self._y, self._z, self._uid)
        self._show()

    def thin(self, alive: np.ndarray) -> None:
        """Take out the rows that are not alive any more, where nothing else has changed."""
        take_out(alive, self.start, self._rows, self._x, self._y, self._z, self._uid)
        self._show()

    def _show(self) -> None:
        self.n = n = int(self.start[-1])
        self.rows, self.x, self.y, self.z, self.uid = (self._rows[:n], self._x[:n], self._y[:n], self._z[:n],
                                                       self._uid[:n])


@njit
def sort_cells(alive, x, y, z, uid, nx, ny, nz, inverse, cell, start, rows, sx, sy, sz, su):
    """Counting sort of the living rows by cell (x fastest), then insertion sort by uid within a cell."""
    n_cells = nx * ny * nz
    start[:] = 0
    for row in range(alive.size):
        if alive[row]:
            cx, cy, cz = (cell_of(x[row] * inverse[0], nx), cell_of(y[row] * inverse[1], ny),
                          cell_of(z[row] * inverse[2], nz))
            c = (cz * ny + cy) * nx + cx
            cell[row] = c
            start[c + 1] += 1
    for c in range(n_cells):
        start[c + 1] += start[c]
    for row in range(alive.size):
        if alive[row]:
            c = cell[row]
            i = start[c]
            start[c] += 1
            rows[i] = row
            su[i] = uid[row]
    for c in range(n_cells, 0, -1):
        start[c] = start[c - 1]
    start[0] = 0
    for c in range(n_cells):
        for i in range(start[c] + 1, start[c + 1]):
            u, row, j = su[i], rows[i], i
            while j > start[c] and su[j - 1] > u:
                su[j] = su[j - 1]
                rows[j] = rows[j - 1]
                j -= 1
            su[j] = u
            rows[j] = row
    for i in range(start[n_cells]):
        row = rows[i]
        sx[i] = x[row]
        sy[i] = y[row]
        sz[i] = z[row]


@njit
def take_out(alive, start, rows, x, y, z, uid):
    """Close the gaps that dead rows leave in an index; the others keep their order."""
    kept, first = 0, 0
    for c in range(start.size - 1):
        end = start[c + 1]
        for i in range(first, end):
            if alive[rows[i]]:
                if kept < i:
                    rows[kept], x[kept], y[kept], z[kept], uid[kept] = rows[i], x[i], y[i], z[i], uid[i]
                kept += 1
        first, start[c + 1] = end, kept
