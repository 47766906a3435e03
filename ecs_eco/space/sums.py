"""Sums over all bodies in reach of a place, weighted by distance: 16 places at a time, as `nearest` does it.

Seekers and bodies are taken in the order of their indexes: sums have the same bits for any order of rows and
any number of threads. It takes up to twice the time of `nearest`.
"""

from collections.abc import Callable

import numpy as np

from ecs_eco.engine.jit import njit
from ecs_eco.space.index import Index

LANES = 16
NONE, LINEAR, INVERSE_SQUARE = 0, 1, 2  # how the weight of a body falls with its distance
DECAYS = {"none": NONE, "linear": LINEAR, "inverse_square": INVERSE_SQUARE}
TOUCHING2 = 1e-12  # [m^2] the least square of a distance


def add_near(seekers: Index, places: tuple[np.ndarray, ...], off: float, radius: np.ndarray, targets: Index,
             value: np.ndarray, size: np.ndarray, decay: int, total: np.ndarray, weight: np.ndarray,
             split: Callable[..., None] | None = None) -> None:
    """Add to total f64[n] each target's value times its weight, and its weight to weight f64[n].

    `places` x, y, z f32[n] [m] are the seekers' own, or others in the space at most `off` [m] away from them;
    `radius` f32[n] [m] is how far each looks, from its place to the centre of a body. `value` and `size` [m],
    the radius of the body, are f32 of the targets in the order of their index. The weight at distance d is 1,
    1 − d/radius, or 1/max(d, size)² [1/m^2]; sums are float32 within a row of cells, float64 over all.
    A seeker is not its own target where both indexes are the same. `split(kernel, n, *arguments)` runs
    a kernel over 0…n in parts.
    """
    space = seekers.space
    nx, ny, nz = space.shape
    arguments = (seekers.start, *places, radius, targets.x, targets.y, targets.z, targets.start, value, size,
                 seekers is targets, space.reach(float(radius.max(initial=0.0)) + off), nx, ny, nz,
                 space.lengths, space.torus, decay, total, weight)
    if split is None:
        add_rows(0, ny * nz, *arguments)
    else:
        split(add_rows, ny * nz, *arguments, work=seekers.n)


@njit
def _add(begin, end, i0, same, seam, decay, tx, ty, tz, value, size, lengths, block, sums):
    """Add the bodies begin … end − 1 to all lanes of a block whose first seeker is i0;
    `seam`: the way may lead across the edge of the torus."""
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
def add_rows(first, last, ostart, px, py, pz, radius, tx, ty, tz, tstart, value, size, same, reach,
             nx, ny, nz, lengths, torus, decay, total, weight):
    """`add_near` for the seekers in the rows of cells first … last − 1."""
    # x, y, z, radius², 1/radius, two sums: one array, so that no check for overlap is compiled in
    block, sums = np.zeros(7 * LANES, np.float32), np.empty(2 * LANES, np.float64)
    all_rows = torus and 2 * reach + 1 >= ny
    y_low, y_high = (0, ny) if all_rows else (-reach, reach + 1)
    for r in range(first, last):
        layer, row = r // ny, r % ny
        ca, i0, stop = 0, ostart[r * nx], ostart[r * nx + nx]
        beyond = torus and (all_rows or row < reach or row + reach >= ny)
        while i0 < stop:
            m = min(LANES, stop - i0)
            for lane in range(LANES):
                i = i0 + min(lane, m - 1)
                block[lane], block[LANES + lane], block[2 * LANES + lane] = px[i], py[i], pz[i]
                block[3 * LANES + lane] = radius[i] * radius[i]
                block[4 * LANES + lane] = np.float32(1.0) / radius[i]
            sums[:] = 0.0
            while ostart[r * nx + ca + 1] <= i0:
                ca += 1
            cb = ca
            while ostart[r * nx + cb + 1] < i0 + m:
                cb += 1
            low, high = ca - reach, cb + reach
            whole = torus and high - low + 1 >= nx
            seam = beyond or (torus and (low < 0 or high >= nx))
            for k in range(max(layer - reach, 0), min(layer + reach, nz - 1) + 1):
                for dy in range(y_low, y_high):
                    j = dy if all_rows else row + dy
                    if not torus and (j < 0 or j >= ny):
                        continue
                    base = (k * ny + (j + ny) % ny) * nx
                    for part in range(3):  # left of the seam, within, right of it
                        a, b = (0, nx) if whole else (max(low, 0), min(high, nx - 1) + 1)
                        if part != 1 and (whole or not torus):
                            continue
                        if part == 0:
                            a, b = low + nx, nx
                        elif part == 2:
                            a, b = 0, high - nx + 1
                        if a < b:
                            _add(tstart[base + a], tstart[base + b], i0, same, seam, decay, tx, ty, tz, value,
                                 size, lengths, block, sums)
            for lane in range(m):
                total[i0 + lane] += sums[lane]
                weight[i0 + lane] += sums[LANES + lane]
            i0 += m
