"""Distance-weighted sums over all bodies in reach of a position, computed for 16 positions at a time, as in
`nearest`.

Seekers and bodies are processed in the order of their indexes, so sums are bit-identical for any order of
rows and any number of threads. A sum takes up to twice as long as `nearest`.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.space.geometry import Extent, floor_between
from ecs_eco.space.index import Entries, Index

LANES = 16
NONE, LINEAR, INVERSE_SQUARE = 0, 1, 2  # how the weight of a body falls with its distance
DECAYS = {"none": NONE, "linear": LINEAR, "inverse_square": INVERSE_SQUARE}
TOUCHING2 = 1e-12  # [m^2] the smallest squared distance


class Looking(NamedTuple):
    """Position and range of each seeker, for kernels: f32[n] [m]."""

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    radius: np.ndarray


class Weighed(NamedTuple):
    """Weights of bodies in a sum, for kernels, in index order."""

    value: np.ndarray  # f32[k]
    size: np.ndarray  # f32[k] [m]
    decay: int  # decrease of a weight with distance


class Sums(NamedTuple):
    """Sums for each seeker, which kernels write: f64[n]."""

    total: np.ndarray
    weight: np.ndarray


def add_near(
    seekers: Index,
    places: tuple[np.ndarray, ...],
    radius: np.ndarray,
    targets: Index,
    value: np.ndarray,
    size: np.ndarray,
    decay: int,
    total: np.ndarray,
    weight: np.ndarray,
    split: Callable[..., None] | None = None,
) -> None:
    """Add each target's value times its weight to total f64[n], and its weight to weight f64[n].

    `places` x, y, z f32[n] [m] are the seekers' or any other positions in the space; `radius` f32[n] [m] is
    each seeker's range, measured to the center of a body. `value` and `size`, the radius of the body [m], are
    f32 arrays in the order of the targets' index. The weight at distance d is 1, 1 − d/radius, or 1/max(d,
    size)² [1/m^2]; sums are float32 within a row of cells and float64 over all rows. A seeker is not its own
    target if both indexes are the same. `split(kernel, n, *arguments)` runs a kernel over 0…n in parts.
    """
    space = seekers.space
    _, ny, nz = space.shape
    arguments = (
        seekers.entries,
        Looking._make((*places, radius)),
        targets.entries,
        Weighed(value, size, decay),
        seekers is targets,
        space.extent,
        Sums(total, weight),
    )
    if split is None:
        add_rows(0, ny * nz, *arguments)
    else:
        split(add_rows, ny * nz, *arguments, work=seekers.n)


@njit
def _take(i0, m, mine, looking, space, block):
    """Copy the positions of m seekers, starting at i0, into a block; on a torus, a position may lie beyond
    the edge if that is nearer to the seeker's body."""
    ox, oy, lengths = mine.x, mine.y, space.lengths
    px, py, pz, radius = looking
    hx, hy = np.float32(0.5) * lengths[0], np.float32(0.5) * lengths[1]
    for lane in range(LANES):
        i = i0 + min(lane, m - 1)
        x, y, r = px[i], py[i], radius[i]
        if space.torus:
            x = x - lengths[0] if x - ox[i] > hx else x
            x = x + lengths[0] if x - ox[i] < -hx else x
            y = y - lengths[1] if y - oy[i] > hy else y
            y = y + lengths[1] if y - oy[i] < -hy else y
        block[lane], block[LANES + lane], block[2 * LANES + lane] = x, y, pz[i]
        block[3 * LANES + lane], block[4 * LANES + lane] = r * r, np.float32(1.0) / r
        block[7 * LANES + lane] = r


@njit
def cells_touched(block, axis, length, inverse, n, torus):
    """Return the first and last cell along an axis that the lanes of a block search.

    On a torus, the first may be below 0 and the last beyond n, but no cell occurs twice.
    """
    start, low, high = axis * LANES, np.float32(np.inf), np.float32(-np.inf)
    for lane in range(LANES):
        place, reach = block[start + lane], block[7 * LANES + lane]
        low, high = min(low, place - reach), max(high, place + reach)
    wider = np.float32(1e-5) * length  # by more than rounding errors
    low, high = (low - wider) * inverse, (high + wider) * inverse
    if not torus:
        return floor_between(low, 0, n), floor_between(high, -1, n - 1)
    first, last = floor_between(low, -n, n), floor_between(high, -n, 2 * n - 1)
    return (first, last) if last - first + 1 < n else (0, n - 1)


@njit
def _add(begin, end, i0, same, seam, targets, weighed, lengths, block, sums):
    """Add the bodies begin … end − 1 to all lanes of a block whose first seeker is i0; `seam` means that the
    displacement may cross the edge of the torus."""
    tx, ty, tz, (value, size, decay) = targets.x, targets.y, targets.z, weighed
    zero, one, Lx, Ly = np.float32(0.0), np.float32(1.0), lengths[0], lengths[1]
    hx, hy = np.float32(0.5) * Lx, np.float32(0.5) * Ly
    for j in range(begin, end):
        own = j - i0 if same else -1
        x, y, z, v = tx[j], ty[j], tz[j], value[j]
        least = max(size[j] * size[j], np.float32(TOUCHING2))
        for lane in range(LANES):
            dx, dy, dz = x - block[lane], y - block[LANES + lane], z - block[2 * LANES + lane]
            if seam:
                dx = dx - Lx if dx > hx else dx
                dx = dx + Lx if dx < -hx else dx
                dy = dy - Ly if dy > hy else dy
                dy = dy + Ly if dy < -hy else dy
            d2 = dx * dx + dy * dy + dz * dz
            if decay == NONE:
                w = one
            elif decay == LINEAR:
                w = one - np.sqrt(d2) * block[4 * LANES + lane]
            else:
                w = one / (d2 if d2 > least else least)
            inside = (d2 < block[3 * LANES + lane]) & (lane != own)
            block[5 * LANES + lane] += v * w if inside else zero
            block[6 * LANES + lane] += w if inside else zero
    for lane in range(LANES):
        sums[lane] += block[5 * LANES + lane]
        sums[LANES + lane] += block[6 * LANES + lane]
        block[5 * LANES + lane], block[6 * LANES + lane] = zero, zero


@njit
def add_rows(
    first: int,
    last: int,
    mine: Entries,
    looking: Looking,
    targets: Entries,
    weighed: Weighed,
    same: bool,
    space: Extent,
    out: Sums,
) -> None:
    """Run `add_near` for the seekers in the rows of cells first … last − 1."""
    nx, ny, nz, inverse, lengths, torus, _ = space
    ostart, tstart, (total, weight) = mine.start, targets.start, out
    # x, y, z, radius², 1/radius, two sums, radius: one array, so that the compiler adds no check for overlap
    block, sums = np.zeros(8 * LANES, np.float32), np.empty(2 * LANES)
    for r in range(first, last):
        i0, stop = ostart[r * nx], ostart[r * nx + nx]
        while i0 < stop:
            m = min(LANES, stop - i0)
            _take(i0, m, mine, looking, space, block)
            x0, x1 = cells_touched(block, 0, lengths[0], inverse[0], nx, torus)
            y0, y1 = cells_touched(block, 1, lengths[1], inverse[1], ny, torus)
            z0, z1 = cells_touched(block, 2, lengths[2], inverse[2], nz, False)
            seam = torus and (
                x0 < 0 or x1 >= nx or x1 - x0 + 1 >= nx or y0 < 0 or y1 >= ny or y1 - y0 + 1 >= ny
            )
            sums[:] = 0.0
            for k in range(z0, z1 + 1):
                for j in range(y0, y1 + 1):
                    base = (k * ny + (j + ny) % ny) * nx
                    for part in range(-1, 2):  # left of the map, on it, right of it
                        a, b = max(x0, part * nx) - part * nx, min(x1, part * nx + nx - 1) - part * nx
                        if a <= b:
                            _add(
                                tstart[base + a],
                                tstart[base + b + 1],
                                i0,
                                same,
                                seam,
                                targets,
                                weighed,
                                lengths,
                                block,
                                sums,
                            )
            for lane in range(m):
                total[i0 + lane] += sums[lane]
                weight[i0 + lane] += sums[LANES + lane]
            i0 += m
