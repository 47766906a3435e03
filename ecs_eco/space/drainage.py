"""Water on a relief: the hollows it fills, and how much land drains into each cell."""

from __future__ import annotations

import heapq

import numpy as np

from ecs_eco.compiled.jit import njit


def drained(height: np.ndarray, sea: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the level f64[ny, nx] [m] to which water would rise in each cell before it ran off, and the
    number of cells i64[ny, nx] that drain through each cell, including itself.

    Water drains off at the edge of the map and into the `sea`, bool[ny, nx]. Hollows are filled from the
    lowest outlet (priority flood: Barnes, Lehman & Mulla 2014, algorithm 2); each cell drains to the one of
    its eight neighbors from which it was reached.
    """
    level = height.astype(np.float64)
    into, order = np.full(height.size, -1, np.int64), np.empty(height.size, np.int64)
    fill(level, sea, into, order)
    area = np.ones(height.size, np.int64)
    gather(into, order, area)
    return level, area.reshape(height.shape)


@njit
def fill(level, sea, into, order):
    """Raise `level` where water collects; write the cell into which each cell drains (−1: off the map), and
    all cells in order from the outlets upward. Among equally low cells, the one with the lower index comes
    first."""
    ny, nx = level.shape
    known = np.zeros(level.size, np.bool_)
    queue = [(np.float64(0.0), np.int64(0)) for _ in range(0)]
    for j in range(ny):
        for i in range(nx):
            if sea[j, i] or j == 0 or i == 0 or j == ny - 1 or i == nx - 1:
                known[j * nx + i] = True
                heapq.heappush(queue, (level[j, i], np.int64(j * nx + i)))
    n = 0
    while len(queue):
        height, cell = heapq.heappop(queue)
        order[n] = cell
        n += 1
        j, i = cell // nx, cell % nx
        for dj in range(-1, 2):
            for di in range(-1, 2):
                b, a = j + dj, i + di
                if b < 0 or a < 0 or b >= ny or a >= nx or known[b * nx + a]:
                    continue
                known[b * nx + a] = True
                into[b * nx + a] = cell
                level[b, a] = max(level[b, a], height)
                heapq.heappush(queue, (level[b, a], np.int64(b * nx + a)))


@njit
def gather(into, order, area):
    """Add each cell's count to the cell into which it drains, from the highest cell down."""
    for k in range(order.size - 1, -1, -1):
        if into[order[k]] >= 0:
            area[into[order[k]]] += area[order[k]]
