"""Nearest neighbors in one index of all entries of another, computed for 16 seekers at a time in cell order.

The seekers in a block are neighbors in a row of cells, so they share candidates; their positions, smallest
distances and nearest entries stay in vector registers. A search takes about 18 ns per seeker with four
targets in reach.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.vectors import LANES, every, floor, load, spread, store, where_less
from ecs_eco.space.geometry import Extent
from ecs_eco.space.index import Entries, Index


class Search(NamedTuple):
    """Range and targets of a search, for kernels."""

    reach: int  # cells on each side
    radius2: np.float32  # [m^2]
    same: bool  # whether seekers are also targets
    flat: bool  # whether z is 0 everywhere


class Found(NamedTuple):
    """Nearest target of each seeker, which kernels write."""

    entry: np.ndarray  # i32[n] in the index of targets, −1: none
    distance2: np.ndarray  # f32[n] [m^2]


def nearest(
    seekers: Index,
    targets: Index,
    radius: float,
    target: np.ndarray,
    distance2: np.ndarray,
    split: Callable[..., None] | None = None,
) -> None:
    """Write the entry of each seeker's nearest target within `radius` [m] (−1: none), and its squared
    distance.

    `target` i32[n seekers] is exact up to 2^24 targets; `distance2` f32[n seekers] [m^2] is radius^2 for a
    seeker without a target. Ties go to the first in the order of cells, by y, then x, then age. A seeker is
    not its own target if both indexes are the same. `split(kernel, n,
    *arguments)` runs a kernel over 0…n in parts.
    """
    space = seekers.space
    _, ny, nz = space.shape
    search, found = search_of(seekers, targets, radius), Found(target, distance2)
    arguments = seekers.entries, targets.entries, space.extent, search, found
    if split is None:
        seek(0, ny * nz, *arguments)
    else:
        split(seek, ny * nz, *arguments, work=2 * seekers.n)


def search_of(seekers: Index, targets: Index, radius: float) -> Search:
    """Return the search for targets within a radius [m], for kernels."""
    flat = seekers.flat and targets.flat
    return Search(seekers.space.reach(radius), np.float32(radius * radius), seekers is targets, flat)


@njit
def _compare(a, b, i0, search, targets, shift_x, shift_y, block):
    """Compare the targets a … b − 1 with all lanes of a block whose first seeker is i0; `flat` means that all
    z are 0."""
    if a >= b:
        return
    tx, ty, tz, same, flat = targets.x, targets.y, targets.z, search.same, search.flat
    x, y, z = load(block, 0), load(block, LANES), load(block, 2 * LANES)
    best, entry = load(block, 3 * LANES), load(block, 4 * LANES)
    shifted = shift_x != 0 or shift_y != 0
    for j in range(a, b):
        u, v = every(tx, j), every(ty, j)
        if shifted:
            u, v = u + spread(shift_x), v + spread(shift_y)
        dx, dy = u - x, v - y
        d = dx * dx + dy * dy
        if not flat:
            dz = every(tz, j) - z
            d = d + dz * dz
        if same and 0 <= j - i0 < LANES:
            d = d + load(block, 6 * LANES - 1 - j + i0)  # infinite in its own lane
        entry = where_less(d, best, spread(np.float32(j)), entry)
        best = where_less(d, best, d, best)
    store(block, 3 * LANES, best)
    store(block, 4 * LANES, entry)


@njit
def _compare_wrapped(a, b, i0, search, targets, shift_x, shift_y, space, block):
    """Like `_compare`, but for a block that spans the torus: every difference is wrapped separately."""
    if a >= b:
        return
    tx, ty, tz, same, flat = targets.x, targets.y, targets.z, search.same, search.flat
    x, y, z = load(block, 0), load(block, LANES), load(block, 2 * LANES)
    best, entry = load(block, 3 * LANES), load(block, 4 * LANES)
    wide, high, half = spread(space.lengths[0]), spread(space.lengths[1]), spread(np.float32(0.5))
    for j in range(a, b):
        dx, dy = every(tx, j) + spread(shift_x) - x, every(ty, j) + spread(shift_y) - y
        dx = dx - wide * floor(dx / wide + half)
        dy = dy - high * floor(dy / high + half)
        d = dx * dx + dy * dy
        if not flat:
            dz = every(tz, j) - z
            d = d + dz * dz
        if same and 0 <= j - i0 < LANES:
            d = d + load(block, 6 * LANES - 1 - j + i0)
        entry = where_less(d, best, spread(np.float32(j)), entry)
        best = where_less(d, best, d, best)
    store(block, 3 * LANES, best)
    store(block, 4 * LANES, entry)


@njit
def _fill(block, mine, i0, m, radius2):
    """Copy the positions of m seekers, starting at i0, into a block, and repeat the last one in the remaining
    lanes."""
    store(block, 3 * LANES, spread(radius2))
    store(block, 4 * LANES, spread(np.float32(-1)))
    if m == LANES:
        store(block, 0, load(mine.x, i0))
        store(block, LANES, load(mine.y, i0))
        store(block, 2 * LANES, load(mine.z, i0))
        return
    for lane in range(LANES):
        i = i0 + min(lane, m - 1)
        block[lane], block[LANES + lane], block[2 * LANES + lane] = mine.x[i], mine.y[i], mine.z[i]


@njit
def seek(
    first: int, last: int, mine: Entries, targets: Entries, space: Extent, search: Search, found: Found
) -> None:
    """Run `nearest` for the seekers in the rows of cells first … last − 1."""
    nx, ny, nz, lengths, torus = space.nx, space.ny, space.nz, space.lengths, space.torus
    k, ostart, tstart, target, distance2 = (
        search.reach,
        mine.start,
        targets.start,
        found.entry,
        found.distance2,
    )
    # x, y, z, smallest distance, its target, and an infinity among zeros: one array, so that the compiler
    # adds no check for overlap
    block = np.zeros(7 * LANES, np.float32)
    block[6 * LANES - 1] = np.inf
    Lx, Ly = lengths[0], lengths[1]
    all_rows = torus and 2 * k + 1 >= ny
    y_low, y_high = (0, ny) if all_rows else (-k, k + 1)
    for r in range(first, last):
        layer, row = r // ny, r % ny
        begin, end = ostart[r * nx], ostart[r * nx + nx]
        ca = 0
        i0 = begin
        while i0 < end:
            m = min(LANES, end - i0)
            _fill(block, mine, i0, m, search.radius2)
            while ostart[r * nx + ca + 1] <= i0:
                ca += 1
            cb = ca
            while ostart[r * nx + cb + 1] < i0 + m:
                cb += 1
            low, high = ca - k, cb + k
            whole = torus and high - low + 1 >= nx
            for tl in range(max(layer - k, 0), min(layer + k, nz - 1) + 1):
                for dy in range(y_low, y_high):
                    tr = dy if all_rows else row + dy
                    shift_y = np.float32(0.0)
                    if tr < 0 or tr >= ny:
                        if not torus:
                            continue
                        shift_y = -Ly if tr < 0 else Ly
                        tr += ny if tr < 0 else -ny
                    base = (tl * ny + tr) * nx
                    for part in range(3):  # left of the map, on it, right of it
                        shift_x = np.float32(0.0)
                        if whole:
                            if part != 1:
                                continue
                            a, b = tstart[base], tstart[base + nx]
                        elif part == 1:
                            a, b = tstart[base + max(low, 0)], tstart[base + min(high, nx - 1) + 1]
                        elif not torus or (part == 0 and low >= 0) or (part == 2 and high < nx):
                            continue
                        elif part == 0:
                            a, b = tstart[base + low + nx], tstart[base + nx]
                            shift_x = -Lx
                        else:
                            a, b = tstart[base], tstart[base + high - nx + 1]
                            shift_x = Lx
                        if whole or all_rows:
                            _compare_wrapped(a, b, i0, search, targets, shift_x, shift_y, space, block)
                        else:
                            _compare(a, b, i0, search, targets, shift_x, shift_y, block)
            for lane in range(m):
                # float32 rounds beyond 2^24
                target[i0 + lane] = min(int(block[4 * LANES + lane]), targets.x.size - 1)
                distance2[i0 + lane] = block[3 * LANES + lane]
            i0 += m
