"""The neighbour index: the living of one table sorted by cell, within a cell by uid; rebuilt in O(n)."""

import threading

import numpy as np

from ecs_eco.engine.jit import lone_njit, njit
from ecs_eco.space.geometry import Space


class Index:
    """The living sorted by place.

    Entry i is row `rows[i]`, at (x[i], y[i], z[i]) [m]; cell c holds entries start[c] to start[c+1]. The
    order of the entries follows from places and uids alone: it is the canonical order of all sums and ties.
    `flat` is whether z is 0 everywhere.
    """

    def __init__(self, space: Space) -> None:
        self.space = space
        self.version = -1
        self.flat = True
        self.lock = threading.Lock()  # held by the thread that builds it
        self.start = np.zeros(space.n_cells + 1, np.int64)
        self._allocate(0)

    def _allocate(self, n: int) -> None:
        self._cell = np.empty(n, np.int32)
        self._rows = np.empty(n, np.int64)
        self._x, self._y, self._z = (np.empty(n, np.float32) for _ in range(3))
        self._uid = np.empty(n, np.uint64)

    def build(self, alive: np.ndarray, x: np.ndarray, y: np.ndarray, z: np.ndarray, uid: np.ndarray,
              thinned: bool = False) -> None:
        """Sort the rows that are alive; all arrays are [rows], places in [0, size):
        others count as in the nearest cell. `thinned`: nothing has changed since, but that some have died."""
        if thinned:
            take_out(alive, self.start, self._rows, self._x, self._y, self._z, self._uid)
        else:
            if alive.size > self._cell.size:
                self._allocate(max(alive.size, 2 * self._cell.size))
            if self.start.size != self.space.n_cells + 1:
                self.start = np.zeros(self.space.n_cells + 1, np.int64)
            self.flat = not sort_cells(alive, x, y, z, uid, *self.space.shape, self.space.inverse, self._cell,
                                       self.start, self._rows, self._x, self._y, self._z, self._uid)
        self.n = n = int(self.start[-1])
        self.rows, self.x, self.y, self.z, self.uid = (self._rows[:n], self._x[:n], self._y[:n], self._z[:n],
                                                       self._uid[:n])


@njit
def sort_cells(alive, x, y, z, uid, nx, ny, nz, inverse, cell, start, rows, sx, sy, sz, su):
    """Counting sort of the living rows by cell (x fastest), then insertion sort by uid within a cell; return
    whether any z is not 0.

    The dead are sorted, too, behind the last cell: a branch for each would take longer.
    """
    n_cells = nx * ny * nz
    find_cells(alive, x, y, z, np.int32(nx), np.int32(ny), np.int32(nz), inverse, cell)
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
    return high != 0


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


@njit
def insert(i, cell, rows, su):
    """Move entry i of a cell to its place by uid among those before it."""
    u, row, j = su[i], rows[i], i
    while j > 0 and su[j - 1] > u and cell[rows[j - 1]] == cell[row]:
        su[j] = su[j - 1]
        rows[j] = rows[j - 1]
        j -= 1
    su[j] = u
    rows[j] = row


@lone_njit
def find_cells(alive, x, y, z, nx, ny, nz, inverse, cell):
    """Write the cell of each living row, as `cell_of` has it, the number of cells for the dead: i32[rows].

    Without branches, so that it becomes vector code.
    """
    zero, one = np.float32(0.0), np.int32(1)
    fx, fy, fz, ix, iy, iz = (np.float32(nx), np.float32(ny), np.float32(nz), inverse[0], inverse[1],
                              inverse[2])
    for k in range(alive.size):
        row = np.uint64(k)
        px, py, pz = x[row] * ix, y[row] * iy, z[row] * iz
        px, py, pz = px if px > zero else zero, py if py > zero else zero, pz if pz > zero else zero
        px, py, pz = px if px < fx else fx, py if py < fy else fy, pz if pz < fz else fz
        cx, cy, cz = min(np.int32(px), nx - one), min(np.int32(py), ny - one), min(np.int32(pz), nz - one)
        cell[row] = (cz * ny + cy) * nx + cx if alive[row] else nx * ny * nz
