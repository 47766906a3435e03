"""Bodies of any shape in one index. Each body is listed in all cells that it touches, so a search finds a
long wall along its whole length without reaching farther than a search for small bodies."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.space.geometry import Extent, Space, floor_between
from ecs_eco.space.shapes import COS, LENGTH, ROUND, SIN, WIDTH, bounds

FEW = 4  # cells; if a body covers more, the corners of its bounds may not touch it


class Solids(NamedTuple):
    """Bodies of any shape from several tables: entry e of table `kind[e]` has the form `form[e]`, as in
    `ecs_eco.space.shapes`, and the row `rows[e]`; the entries entry[start[c]:start[c + 1]] touch cell c. The
    entries of each table are in the order of its index."""

    form: np.ndarray  # f32[n, 9]
    rows: np.ndarray  # i64[n]
    uid: np.ndarray  # u64[n]
    kind: np.ndarray  # i32[n]
    start: np.ndarray  # i64[cells + 1]
    entry: np.ndarray  # i64


def listed_solids(space: Space, tables: Sequence[tuple[np.ndarray, ...]]) -> Solids:
    """Return the solids of several tables, each given as (form, rows, uid)."""
    none = (np.zeros((0, 9), np.float32), np.zeros(0, np.int64), np.zeros(0, np.uint64))
    form, rows, uid = (np.concatenate(parts) for parts in zip(none, *tables, strict=True))
    kind = np.repeat(np.arange(len(tables)), [len(t[0]) for t in tables]).astype(np.int32)
    start = np.zeros(space.n_cells + 1, np.int64)
    listed(form, space.extent, start, np.zeros(0, np.int64))
    entry = np.empty(int(start[-1]), np.int64)
    listed(form, space.extent, start, entry)
    return Solids(form, rows, uid, kind, start, entry)


@njit
def cells_between(low, high, inverse, length, n, torus):
    """Return the first and last cell along an axis that low … high [m] touches; on a torus, the first may be
    below 0 and the last beyond n, but no cell occurs twice."""
    wider = 1e-5 * length  # by more than rounding errors
    low, high = np.float32((low - wider) * inverse), np.float32((high + wider) * inverse)
    if not torus:
        first = min(floor_between(low, 0, n), n - 1)
        return first, max(floor_between(high, -1, n - 1), first)
    first, last = floor_between(low, -n, n), floor_between(high, -n, 2 * n - 1)
    return (first, last) if last - first + 1 < n else (0, n - 1)


@njit
def _misses(form, e, x, y, half_x, half_y):
    """Return whether a cell with these half sides, centered at (x, y) relative to a body's center, lies
    beyond one of the body's sides and so does not touch it."""
    c, s = abs(np.float64(form[e, COS])), abs(np.float64(form[e, SIN]))
    ahead = x * np.float64(form[e, COS]) + y * np.float64(form[e, SIN])
    aside = y * np.float64(form[e, COS]) - x * np.float64(form[e, SIN])
    r = np.float64(form[e, ROUND])
    return (
        abs(ahead) > np.float64(form[e, LENGTH]) + r + half_x * c + half_y * s
        or abs(aside) > np.float64(form[e, WIDTH]) + r + half_x * s + half_y * c
    )


@njit
def listed(form: np.ndarray, space: Extent, start: np.ndarray, entry: np.ndarray) -> None:
    """Count the entries of each cell in `start` or, if `entry` is not empty, list them there."""
    nx, ny, nz, inverse, lengths, torus, _ = space
    count = entry.size == 0
    wx, wy = 1.0 / np.float64(inverse[0]), 1.0 / np.float64(inverse[1])
    if count:
        start[:] = 0
    for e in range(len(form)):
        x, y, z = np.float64(form[e, 0]), np.float64(form[e, 1]), np.float64(form[e, 2])
        ex, ey, ez = bounds(form, e)
        x0, x1 = cells_between(x - ex, x + ex, inverse[0], lengths[0], nx, torus)
        y0, y1 = cells_between(y - ey, y + ey, inverse[1], lengths[1], ny, torus)
        z0, z1 = cells_between(z - ez, z + ez, inverse[2], lengths[2], nz, False)
        whole = x1 - x0 + 1 >= nx or y1 - y0 + 1 >= ny
        many = (x1 - x0 + 1) * (y1 - y0 + 1) > FEW and not (torus and whole)
        for j in range(y0, y1 + 1):
            for i in range(x0, x1 + 1):
                if many and _misses(form, e, (i + 0.5) * wx - x, (j + 0.5) * wy - y, 0.501 * wx, 0.501 * wy):
                    continue
                for k in range(z0, z1 + 1):
                    c = (k * ny + (j + ny) % ny) * nx + (i + nx) % nx
                    if count:
                        start[c + 1] += 1
                    else:
                        entry[start[c]] = e
                        start[c] += 1
    n = start.size - 1
    if count:
        for c in range(n):
            start[c + 1] += start[c]
    else:
        for c in range(n, 0, -1):
            start[c] = start[c - 1]
        start[0] = 0


@njit
def around(x, y, z, ex, ey, ez, solids, space, seen, out):
    """Write the entries in the cells touched by a box with these half sides [m] around a position, each once
    and in a fixed order; return their number.

    `seen` i64[n + 1] is initially 0 and records the call that last found each entry; `out` i64[n] can hold
    all entries.
    """
    nx, ny, nz, inverse, lengths, torus, _ = space
    start, entry = solids.start, solids.entry
    x0, x1 = cells_between(x - ex, x + ex, inverse[0], lengths[0], nx, torus)
    y0, y1 = cells_between(y - ey, y + ey, inverse[1], lengths[1], ny, torus)
    z0, z1 = cells_between(z - ez, z + ez, inverse[2], lengths[2], nz, False)
    call, n = seen[-1] + 1, 0
    seen[-1] = call
    for k in range(z0, z1 + 1):
        for j in range(y0, y1 + 1):
            base = (k * ny + (j + ny) % ny) * nx
            for i in range(x0, x1 + 1):
                c = base + (i + nx) % nx
                for q in range(start[c], start[c + 1]):
                    e = entry[q]
                    if seen[e] != call:
                        seen[e] = call
                        out[n] = e
                        n += 1
    return n
