"""Spherical bodies from several tables in one index."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.space.geometry import Space
from ecs_eco.space.index import Entries, Index


class Spheres(NamedTuple):
    """Spheres from several tables in one index, for kernels: entry i belongs to table `kind[i]`."""

    x: np.ndarray  # f32[n] [m]
    y: np.ndarray
    z: np.ndarray
    radius: np.ndarray  # f32[n] [m]
    uid: np.ndarray  # u64[n]
    kind: np.ndarray  # i32[n]
    start: np.ndarray  # i64[cells + 1]
    largest: np.float32  # [m], the largest of all radii


_NONE = np.zeros(0, np.float32)
NO_SPHERES = Spheres(
    _NONE,
    _NONE,
    _NONE,
    _NONE,
    np.zeros(0, np.uint64),
    np.zeros(0, np.int32),
    np.zeros(1, np.int64),
    np.float32(0.0),
)


def merged_spheres(space: Space, tables: Sequence[tuple[Index, np.ndarray]]) -> Spheres:
    """Merge the indexes of `tables`, each with the radii of its rows f32[capacity]."""
    n, there = 0, 0
    for index, _ in tables:
        n += index.n
    four = np.empty((4, n), np.float32)  # accessed row by row, because unpacking an array takes longer
    start, largest = np.zeros(space.n_cells + 1, np.int64), np.float32(0.0)
    uid, kinds = np.empty(n, np.uint64), np.empty(n, np.int32)
    all_of_them = Spheres(four[0], four[1], four[2], four[3], uid, kinds, start, largest)
    for kind, (index, radius) in enumerate(tables):
        most = merge(there, kind, index.entries, radius, all_of_them)
        largest, there = max(largest, np.float32(most)), there + index.n
    return Spheres(*all_of_them[:-1], largest)


@njit
def merge(there: int, kind: int, entries: Entries, tradius: np.ndarray, spheres: Spheres) -> np.float32:
    """Merge the entries of an index, all of one kind, into the first `there` entries, from last to first, by
    cell and then by uid; return the largest radius."""
    trows, tx, ty, tz, tuid, tstart = entries
    x, y, z, radius, uid, kinds, start, _ = spheres
    i, j, a, b, largest = there - 1, tx.size - 1, start.size - 1, start.size - 1, np.float32(0.0)
    if there == 0:
        for k in range(j + 1):
            x[k], y[k], z[k], radius[k] = tx[k], ty[k], tz[k], tradius[trows[k]]
            uid[k], kinds[k] = tuid[k], kind
            largest = max(largest, radius[k])
        j = -1
    while j >= 0:
        while tstart[b] > j:
            b -= 1
        while i >= 0 and start[a] > i:
            a -= 1
        k = i + j + 1
        if i >= 0 and (a > b or (a == b and uid[i] > tuid[j])):
            x[k], y[k], z[k], radius[k], uid[k], kinds[k] = x[i], y[i], z[i], radius[i], uid[i], kinds[i]
            i -= 1
        else:
            x[k], y[k], z[k], radius[k] = tx[j], ty[j], tz[j], tradius[trows[j]]
            uid[k], kinds[k] = tuid[j], kind
            largest = max(largest, radius[k])
            j -= 1
    for c in range(start.size):
        start[c] += tstart[c]
    return largest
