"""Capsules and boxes: the distance between bodies of any shape, and the points at which rays meet them.

A body is a row of `form` f32[n, 9]: the position of its center x, y, z [m]; half the length, width and height
of the box within it [m]; the radius of its rounding [m]; cosine and sine of its heading. A sphere has only a
rounding, a capsule has a length and a rounding, and a box has no rounding. An upright box, rotated about the
vertical, is the product of a rectangle and an interval, so the squared distance between two such boxes is the
sum of the squared distances between the rectangles and between the intervals. Methods follow Ericson,
Real-Time Collision Detection (2005), sections 4.4, 4.5, 5.1 to 5.3 and 5.5. Calculations use float64.
"""

import math
from typing import Any, TypeAlias

import numpy as np

from ecs_eco.compiled.elementary import power
from ecs_eco.compiled.jit import njit

Size: TypeAlias = float | np.ndarray
X, Y, Z, LENGTH, WIDTH, HEIGHT, ROUND, COS, SIN = range(9)
CONCENTRIC = 1e-9  # [m] a distance without a direction
TURNED = 2e-7  # relative error of a corner, because cosine and sine are float32


def volume(length: Size, width: Size, height: Size, rounding: Size) -> Any:
    """Return the volume [m^3] of a box with these sides [m], enlarged on all sides by a rounding [m] (Steiner
    1840); takes numbers or arrays."""
    flat = length * width + width * height + height * length
    return (
        length * width * height
        + 2 * rounding * flat
        + math.pi * power(rounding, 2) * (length + width + height)
        + 4 / 3 * math.pi * power(rounding, 3)
    )


def surface(length: Size, width: Size, height: Size, rounding: Size) -> Any:
    """Return the surface area [m^2] of a box enlarged as in `volume`."""
    flat = length * width + width * height + height * length
    return 2 * flat + 2 * math.pi * rounding * (length + width + height) + 4 * math.pi * power(rounding, 2)


@njit
def _spread(form, i, nx, ny):
    """Return how far the rectangle within a body extends from its center along a unit vector."""
    a, b, c, s = (
        np.float64(form[i, LENGTH]),
        np.float64(form[i, WIDTH]),
        np.float64(form[i, COS]),
        np.float64(form[i, SIN]),
    )
    return a * abs(nx * c + ny * s) + b * abs(ny * c - nx * s)


@njit
def bounds(form, i):
    """Return how far a body extends from its center along x, y and z [m]."""
    r = np.float64(form[i, ROUND])
    return _spread(form, i, 1.0, 0.0) + r, _spread(form, i, 0.0, 1.0) + r, np.float64(form[i, HEIGHT]) + r


@njit
def _corner(form, i, k):
    """Return corner k of the rectangle within a body, relative to its center."""
    a = np.float64(form[i, LENGTH]) if k & 1 else -np.float64(form[i, LENGTH])
    b = np.float64(form[i, WIDTH]) if k & 2 else -np.float64(form[i, WIDTH])
    c, s = np.float64(form[i, COS]), np.float64(form[i, SIN])
    return a * c - b * s, a * s + b * c


@njit
def nearest_on(form, e, dx, dy):
    """Return the point of the rectangle within body e nearest to (dx, dy), both relative to its center."""
    c, s = np.float64(form[e, COS]), np.float64(form[e, SIN])
    a, b = np.float64(form[e, LENGTH]), np.float64(form[e, WIDTH])
    u, v = min(max(dx * c + dy * s, -a), a), min(max(dy * c - dx * s, -b), b)
    return u * c - v * s, u * s + v * c


@njit
def _part(form, i, other, e, dx, dy, tie):
    """Return the distance between the rectangles of two bodies along the best of their four axes, negative if
    they overlap, and that axis from e to i (separating axes: Ericson 2005, section 5.2.1)."""
    best, ax, ay = -np.inf, 1.0, 0.0
    for k in range(4):
        c, s = (
            (np.float64(other[e, COS]), np.float64(other[e, SIN]))
            if k < 2
            else (np.float64(form[i, COS]), np.float64(form[i, SIN]))
        )
        nx, ny = (c, s) if k % 2 == 0 else (-s, c)
        along = dx * nx + dy * ny
        gap = abs(along) - _spread(form, i, nx, ny) - _spread(other, e, nx, ny)
        if gap > best:
            sign = tie if abs(along) < CONCENTRIC else (1.0 if along > 0 else -1.0)
            best, ax, ay = gap, sign * nx, sign * ny
    return best, ax, ay


@njit
def closest(form, i, other, e, dx, dy):
    """Return the nearest points on the rectangles of two bodies i and e that do not overlap, both relative to
    the center of e; (dx, dy) is the center of i relative to the center of e.

    One of the two points is always a corner.
    """
    best, px, py, qx, qy = np.inf, dx, dy, 0.0, 0.0
    for k in range(4):
        x, y = _corner(form, i, k)
        x, y = x + dx, y + dy
        u, v = nearest_on(other, e, x, y)
        d2 = (x - u) ** 2 + (y - v) ** 2
        if d2 < best:
            best, px, py, qx, qy = d2, x, y, u, v
        x, y = _corner(other, e, k)
        u, v = nearest_on(form, i, x - dx, y - dy)
        u, v = u + dx, v + dy
        d2 = (x - u) ** 2 + (y - v) ** 2
        if d2 < best:
            best, px, py, qx, qy = d2, u, v, x, y
    return px, py, qx, qy


@njit
def _size(form, i):
    return np.float64(form[i, LENGTH]) + np.float64(form[i, WIDTH])


@njit
def contact(form, i, other, e, dx, dy, dz, volume, tie):
    """Return the distance [m] between the surfaces of two bodies, and the direction, as a unit vector, of the
    shortest push on i that separates them. If they overlap, the distance is minus the length of that push.

    (dx, dy, dz) [m] is the center of i relative to the center of e. In two dimensions, heights are ignored.
    `tie`, 1 or −1, decides the direction in which i is pushed if both have the same center.
    """
    rounding = np.float64(form[i, ROUND]) + np.float64(other[e, ROUND])
    apart, nx, ny = _part(form, i, other, e, dx, dy, tie)
    upright = abs(dz) - np.float64(form[i, HEIGHT]) - np.float64(other[e, HEIGHT]) if volume else -np.inf
    up = tie if abs(dz) < CONCENTRIC else (1.0 if dz > 0 else -1.0)
    if apart <= 0:
        if upright > apart:
            return upright - rounding, 0.0, 0.0, up
        return apart - rounding, nx, ny, 0.0
    px, py, qx, qy = closest(form, i, other, e, dx, dy)
    flat = math.hypot(px - qx, py - qy)
    if flat > CONCENTRIC + TURNED * (_size(form, i) + _size(other, e)):
        nx, ny = (px - qx) / flat, (py - qy) / flat
    if upright <= 0:
        return flat - rounding, nx, ny, 0.0
    far = math.hypot(flat, upright)
    return far - rounding, nx * flat / far, ny * flat / far, up * upright / far


@njit
def ray(form, e, ox, oy, oz, ux, uy, uz):
    """Return how far along a ray a body begins, in units of the length of (ux, uy, uz): 0 inside the body,
    infinite if the ray misses it. The ray begins at (ox, oy, oz) [m] relative to the body's center.

    Boxes use the slab method (Ericson 2005, section 5.3.3); capsules are a cylinder and two spheres.
    """
    c, s = np.float64(form[e, COS]), np.float64(form[e, SIN])
    a, b, h, r = (
        np.float64(form[e, LENGTH]),
        np.float64(form[e, WIDTH]),
        np.float64(form[e, HEIGHT]),
        np.float64(form[e, ROUND]),
    )
    x, y, z = ox * c + oy * s, oy * c - ox * s, oz
    dx, dy, dz = ux * c + uy * s, uy * c - ux * s, uz
    if b > 0 or h > 0:  # a box; rounded edges count as sharp
        begin, end = -np.inf, np.inf
        for k in range(3):
            at, d, half = (x, dx, a + r) if k == 0 else (y, dy, b + r) if k == 1 else (z, dz, h + r)
            if d == 0:
                if abs(at) > half:
                    return np.inf
                continue
            near, far = (-half - at) / d, (half - at) / d
            begin, end = max(begin, min(near, far)), min(end, max(near, far))
        return max(begin, 0.0) if begin <= end and end >= 0 else np.inf
    inner = min(max(x, -a), a)
    if (x - inner) ** 2 + y * y + z * z <= r * r:
        return 0.0
    best = np.inf
    across, towards = dy * dy + dz * dz, y * dy + z * dz
    root = towards * towards - across * (y * y + z * z - r * r)
    if across > 0 and root >= 0:
        t = (-towards - math.sqrt(root)) / across
        if t >= 0 and abs(x + t * dx) <= a:
            best = t
    whole = dx * dx + across
    for k in range(2):
        end = a if k else -a
        towards = (x - end) * dx + y * dy + z * dz
        root = towards * towards - whole * ((x - end) ** 2 + y * y + z * z - r * r)
        if whole > 0 and root >= 0:
            t = (-towards - math.sqrt(root)) / whole
            if 0 <= t < best:
                best = t
    return best


@njit
def shift_to(d, length, limit, image):
    """Return the difference d along an axis of a torus for the nearest image (0) or the next-nearest one (1);
    infinite if that one is farther away than `limit` [m]."""
    d = d - length * math.floor(d / length + 0.5)
    if image == 0:
        return d
    d = d - length if d > 0 else d + length
    return d if abs(d) <= limit else np.inf


@njit
def image_of(dx, dy, space, image):
    """Return displacements on a torus to the nearest image (0), or to the next image along x (1), y (2) or
    both (3), infinite if that image is farther away than the length of the torus; between walls, return them
    unchanged."""
    if not space.torus:
        return dx, dy
    wide, high = space.lengths[0], space.lengths[1]
    ax = shift_to(dx, wide, np.float64(wide), image % 2)
    return ax, shift_to(dy, high, np.float64(high), image // 2)


@njit
def touching(form, i, other, e, dx, dy, dz, space):
    """Return the distance [m] between the surfaces of two bodies (the shorter way around on a torus, negative
    if they overlap), and the vector from the center of i to its point nearest to e. (dx, dy, dz) [m] is the
    center of i relative to the center of e."""
    images, best, wx, wy, wz = 2 if space.torus else 1, np.inf, 0.0, 0.0, 0.0
    r = np.float64(form[i, ROUND])
    for image in range(images * images):
        ax, ay = image_of(dx, dy, space, image)
        if abs(ax) == np.inf or abs(ay) == np.inf:
            continue
        gap, nx, ny, nz = contact(form, i, other, e, ax, ay, dz, space.volume, 1.0)
        if gap < best:
            best = gap
            px, py, _, _ = closest(form, i, other, e, ax, ay)
            wx, wy, wz = px - ax - r * nx, py - ay - r * ny, -nz
    return best, wx, wy, wz
