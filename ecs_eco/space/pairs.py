"""All pairs of a position and a body within a radius of it, found with the neighbor index.

Two passes over the cells in reach, one that counts and one that writes, allow threads to divide the positions
among them. The order of the result depends only on the positions and the index.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ecs_eco.compiled.jit import njit
from ecs_eco.space.geometry import Extent, Places, Space, back_into, floor_between
from ecs_eco.space.index import Entries, Index


class Pairs(NamedTuple):
    """Pairs of neighbors, as arrays: `rows, others, distance = pairs`.

    Attributes
    ----------
    rows : array of int64, shape (k,)
        Rows of the first table, or indices of positions.
    others : array of int64, shape (k,)
        Rows of the other table.
    distance : array of float32, shape (k,)
        Distance [m] between centers; on a torus, the shorter way around.
    """

    rows: np.ndarray  # i64, rows of the first table, or indices of positions
    others: np.ndarray  # i64, rows of the other table
    distance: np.ndarray  # f32 [m], between centers; on a torus, the shorter way around


def pairs(
    places: tuple[np.ndarray, ...],
    rows: np.ndarray,
    radius: np.ndarray,
    targets: Index,
    same: bool,
    split: Callable[..., None] | None = None,
) -> Pairs:
    """Return every pair of a position and a target within the position's radius.

    `places` x, y, z f32[n] [m] must lie in the space, `rows` i64[n] labels them in the result, and `radius`
    is f32[n] [m]. Pairs are ordered by position, then by index entry. If the positions come from the targets'
    own index (`same`), no entity is paired with itself. `split(kernel, n, *arguments)` runs a kernel over 0…n
    in parts.
    """
    space, n = targets.space, len(rows)
    start, nothing = np.zeros(n + 1, np.int64), (np.empty(0, np.int64), np.empty(0, np.float32))
    arguments = (Places(*places), radius, same, targets.entries, space.extent, start)
    _run(split, n, *arguments, *nothing)
    np.cumsum(start, out=start)
    k = int(start[-1])
    entry, distance2 = np.empty(k, np.int64), np.empty(k, np.float32)
    if k:
        _run(split, n, *arguments, entry, distance2)
    return Pairs(np.repeat(rows, np.diff(start)), targets.rows[entry], np.sqrt(distance2))


def places_in(space: Space, places: ArrayLike) -> tuple[np.ndarray, ...]:
    """Return positions [n, axes] [m] as x, y, z f32[n] within the space: wrapped around a torus, unchanged
    between walls.

    Raises a ValueError if the shape is wrong, a number is not finite, or a position is beyond the walls.
    """
    axes, array = len(space.size), np.asarray(places, np.float64)
    if array.ndim != 2 or array.shape[1] != axes:
        raise ValueError(
            f"places: an array of shape {array.shape}; expected (n, {axes}): "
            f"{', '.join('xyz'[:axes])} of each place [m]"
        )
    if (wrong := np.argwhere(~np.isfinite(array))).size:
        place, axis = wrong[0]
        raise ValueError(
            f"places[{place}].{'xyz'[axis]} is {array[place, axis]}; expected finite numbers [m]"
        )
    out = []
    for axis, length in enumerate(space.size):
        v = array[:, axis]
        if not space.wrap[axis] and (beyond := np.flatnonzero((v < 0) | (v > length))).size:
            raise ValueError(
                f"places[{beyond[0]}].{'xyz'[axis]} is {v[beyond[0]]:g}; "
                f"expected 0 to {length:g} m, between the walls"
            )
        out.append(back_into(v, length, space.wrap[axis]).astype(np.float32))
    return (*out, *[np.zeros(len(array), np.float32)] * (3 - axes))


def radii(radius: ArrayLike, n: int, rows: np.ndarray | None = None) -> np.ndarray:
    """Return a radius for each of n seekers, f32[n] [m], from a number or an array.

    An array contains one radius per seeker or, if seekers are the `rows` i64[n] of a table, one per row of
    the table. Raises a ValueError if the length is wrong or a number is negative or NaN.
    """
    array, least = np.asarray(radius, np.float32), n if rows is None else int(rows.max(initial=-1)) + 1
    if array.ndim > 1 or (array.ndim == 1 and (array.size != n if rows is None else array.size < least)):
        allowed = f"({n},), one for each place" if rows is None else f"({least},) or more, one for each row"
        raise ValueError(f"radius: an array of shape {array.shape}; expected a number, or {allowed}")
    if array.ndim == 1 and rows is not None:
        array = array[rows]
    if not (array >= 0).all():
        raise ValueError(f"radius is {array[~(array >= 0)].flat[0]}; expected at least 0 m")
    return np.ascontiguousarray(np.broadcast_to(array, n))


def _run(split: Callable[..., None] | None, n: int, *arguments: object) -> None:
    if split is None:
        pair(0, n, *arguments)
    else:
        split(pair, n, *arguments, work=n)


@njit
def _cells(place, reach, length, inverse, n, torus):
    """Return the first and last cell of a search along one axis; on a torus, the first may be below 0 and the
    last beyond n, but no cell occurs twice."""
    wider = reach + np.float32(1e-5) * length  # by more than rounding errors
    low, high = (place - wider) * inverse, (place + wider) * inverse
    if not torus:
        return floor_between(low, 0, n), floor_between(high, -1, n - 1)
    first, last = floor_between(low, -n, n), floor_between(high, -n, 2 * n - 1)
    return (first, last) if last - first + 1 < n else (0, n - 1)


@njit
def _shorter(d, length):
    """Return the difference between two positions on a ring, the shorter way around."""
    half = np.float32(0.5) * length
    d = d - length if d > half else d
    return d + length if d < -half else d


@njit
def _count(begin, end, own, x, y, z, radius2, targets, seam, lengths):
    """Return how many of the targets begin … end − 1, except `own`, are near a position."""
    n, tx, ty, tz = np.int64(0), targets.x, targets.y, targets.z
    for t in range(begin, end):  # branch-free, so that it vectorizes
        dx, dy, dz = tx[t] - x, ty[t] - y, tz[t] - z
        if seam:
            dx, dy = _shorter(dx, lengths[0]), _shorter(dy, lengths[1])
        n += np.int64((dx * dx + dy * dy + dz * dz < radius2) & (t != own))
    return n


@njit
def _write(begin, end, own, x, y, z, radius2, targets, seam, lengths, n, stop, entry, distance2):
    """Write the targets that `_count` counts, starting at index n, until all are found at `stop`; return the
    index after the last one.

    Every target is written, then overwritten by the next one if it is not near, because this costs less than
    a branch.
    """
    tx, ty, tz = targets.x, targets.y, targets.z
    for t in range(begin, end):
        if n == stop:
            break
        dx, dy, dz = tx[t] - x, ty[t] - y, tz[t] - z
        if seam:
            dx, dy = _shorter(dx, lengths[0]), _shorter(dy, lengths[1])
        d2 = dx * dx + dy * dy + dz * dz
        entry[n], distance2[n] = t, d2
        n += np.int64((d2 < radius2) & (t != own))
    return n


@njit
def pair(
    first: int,
    last: int,
    places: Places,
    radius: np.ndarray,
    same: bool,
    targets: Entries,
    space: Extent,
    start: np.ndarray,
    entry: np.ndarray,
    distance2: np.ndarray,
) -> None:
    """Count the targets near positions first … last − 1 in start[place + 1] or, if `distance2` is not empty,
    write them beginning at start[place]."""
    (px, py, pz), (nx, ny, nz, inverse, lengths, torus, _) = places, space
    counts, tstart = distance2.size == 0, targets.start
    for i in range(first, last):
        x, y, z, r = px[i], py[i], pz[i], radius[i]
        x0, x1 = _cells(x, r, lengths[0], inverse[0], nx, torus)
        y0, y1 = _cells(y, r, lengths[1], inverse[1], ny, torus)
        z0, z1 = _cells(z, r, lengths[2], inverse[2], nz, False)
        seam = torus and (x0 < 0 or x1 >= nx or x1 - x0 + 1 >= nx or y0 < 0 or y1 >= ny or y1 - y0 + 1 >= ny)
        n = 0 if counts else start[i]
        for k in range(z0, z1 + 1):
            for j in range(y0, y1 + 1):
                base = (k * ny + (j + ny) % ny) * nx
                for part in range(-1, 2):  # left of the map, on it, right of it
                    a, b = max(x0, part * nx) - part * nx, min(x1, part * nx + nx - 1) - part * nx
                    if a > b:
                        continue
                    c, d, own = tstart[base + a], tstart[base + b + 1], i if same else -1
                    if counts:
                        n += _count(c, d, own, x, y, z, r * r, targets, seam, lengths)
                    else:
                        n = _write(
                            c,
                            d,
                            own,
                            x,
                            y,
                            z,
                            r * r,
                            targets,
                            seam,
                            lengths,
                            n,
                            start[i + 1],
                            entry,
                            distance2,
                        )
        if counts:
            start[i + 1] = n
