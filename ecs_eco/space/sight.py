"""Sight: rays and lines of sight that end at the first opaque body, rock or hill."""

from typing import NamedTuple

import numpy as np

from ecs_eco.compiled.jit import lone_njit, njit
from ecs_eco.compiled.per_row import Number, of_row, row_of
from ecs_eco.space.geometry import Extent, cell_of, floor_between, half_cells, wrapped
from ecs_eco.space.spheres import Spheres
from ecs_eco.space.terrain import ROCK, Ground, ground_at, hill_between


class Poses(NamedTuple):
    """Position and direction of each seeker, in canonical order, for kernels."""

    x: np.ndarray  # f32[n] [m]
    y: np.ndarray
    z: np.ndarray
    uid: np.ndarray  # u64[n]
    cos: np.ndarray  # f32[n], cosine of the heading
    sin: np.ndarray


class Sight(NamedTuple):
    """Range and obstacles of sight, for kernels; heights may be numbers if no hill blocks sight."""

    radius: np.float32  # [m]
    reach: int  # cells on each side
    cos_half_fov: Number  # f32, or f32[n]
    occlusion: bool
    eye: Number  # f32[n] [m], height of each seeker's eyes
    top: Number  # f32[k] [m], height of each target


class Rays(NamedTuple):
    """Rays in the horizontal plane, given by their angles from the heading, and their hits, for kernels."""

    cos: np.ndarray  # f32[rays], or f32[n, rays]
    sin: np.ndarray
    radius: np.float32  # range [m]
    eye: np.ndarray  # f32[n] [m], height of each seeker's eyes
    hit: np.ndarray  # i32[n, rays], kind of the first body; −1: none, −2: rock or wall
    distance: np.ndarray  # f32[n, rays] [m]


@lone_njit
def gather(x, y, z, reach, bodies, space, out):
    """Write the entries in cells within `reach` cells of a position, each once, in a fixed order; return
    their number."""
    nx, ny, nz, inverse, torus, start = space.nx, space.ny, space.nz, space.inverse, space.torus, bodies.start
    cx, cy, cz = cell_of(x * inverse[0], nx), cell_of(y * inverse[1], ny), cell_of(z * inverse[2], nz)
    x0, x1, y0, y1 = cx - reach, cx + reach, cy - reach, cy + reach
    if torus:
        if x1 - x0 + 1 >= nx:
            x0, x1 = 0, nx - 1
        if y1 - y0 + 1 >= ny:
            y0, y1 = 0, ny - 1
    else:
        x0, x1, y0, y1 = max(x0, 0), min(x1, nx - 1), max(y0, 0), min(y1, ny - 1)
    n = 0
    for k in range(max(cz - reach, 0), min(cz + reach, nz - 1) + 1):
        for j in range(y0, y1 + 1):
            row = (k * ny + (j + ny) % ny) * nx
            for part in range(3):  # left of the map, on it, right of it
                a, b, base = max(x0, 0), min(x1, nx - 1), row
                if part == 0:
                    a, b, base = x0, min(x1, -1), row + nx
                elif part == 2:
                    a, b, base = max(x0, nx), x1, row - nx
                if a <= b:
                    for e in range(start[base + a], min(start[base + b + 1], start[base + a] + out.size - n)):
                        out[n] = e
                        n += 1
    return n


@njit
def offset(ax, ay, az, bx, by, bz, space):
    """Return the shortest displacement from a to b."""
    dx, dy, dz = bx - ax, by - ay, bz - az
    if space.torus:
        dx, dy = wrapped(dx, space.lengths[0]), wrapped(dy, space.lengths[1])
    return dx, dy, dz


@njit
def rock_between(x, y, dx, dy, ground, space):
    """Return the share of the displacement (dx, dy) at which rock begins; 2 if there is none."""
    if ground.kind.size == 1:
        return np.float32(2.0)
    lengths, torus = space.lengths, space.torus
    steps = half_cells(np.sqrt(dx * dx + dy * dy), ground.inverse, lengths)
    for s in range(1, steps + 1):
        t = np.float32(s) / np.float32(steps)
        px, py = x + t * dx, y + t * dy
        if torus:
            px -= lengths[0] * np.float32(np.floor(px / lengths[0]))
            py -= lengths[1] * np.float32(np.floor(py / lengths[1]))
        elif px < 0 or py < 0 or px >= lengths[0] or py >= lengths[1]:
            break
        if ground_at(ground, px, py) == ROCK:
            return t
    return np.float32(2.0)


@njit
def hidden(x, y, z, dx, dy, dz, me, it, bodies, space):
    """Return whether a body other than `me` and `it`, the two ends, intersects the line from (x, y, z) along
    (dx, dy, dz).

    Checks the cells of the line's bounding box, widened by the largest radius of a body.
    """
    bx, by, bz, br, bu, _, start, margin = bodies
    nx, ny, nz, _, lengths, torus, _ = space
    zero, half = np.float32(0.0), np.float32(0.5)
    ax, ay = nx / lengths[0], ny / lengths[1]
    i0, i1 = (
        floor_between((x + min(dx, zero) - margin) * ax, -nx, nx),
        floor_between((x + max(dx, zero) + margin) * ax, -nx, 2 * nx - 1),
    )
    j0, j1 = (
        floor_between((y + min(dy, zero) - margin) * ay, -ny, ny),
        floor_between((y + max(dy, zero) + margin) * ay, -ny, 2 * ny - 1),
    )
    k0, k1 = 0, 0
    if nz > 1:
        az = nz / lengths[2]
        k0 = floor_between((z + min(dz, zero) - margin) * az, 0, nz)
        k1 = floor_between((z + max(dz, zero) + margin) * az, -1, nz - 1)
    # if the box wraps around, use the image nearest to the line's middle
    around = torus and (i1 - i0 >= nx or j1 - j0 >= ny)
    if torus:
        i1, j1 = min(i1, i0 + nx - 1), min(j1, j0 + ny - 1)
    else:
        i0, i1, j0, j1 = max(i0, 0), min(i1, nx - 1), max(j0, 0), min(j1, ny - 1)
    d2 = dx * dx + dy * dy + dz * dz
    for k in range(k0, k1 + 1):
        for j in range(j0, j1 + 1):
            row, fy = j, y
            if j < 0:
                row, fy = j + ny, y + lengths[1]
            elif j >= ny:
                row, fy = j - ny, y - lengths[1]
            for part in range(3):  # left of the map, on it, right of it
                a, b, base, fx = max(i0, 0), min(i1, nx - 1), (k * ny + row) * nx, x
                if part == 0:
                    a, b, base, fx = i0, min(i1, -1), base + nx, x + lengths[0]
                elif part == 2:
                    a, b, base, fx = max(i0, nx), i1, base - nx, x - lengths[0]
                if a > b:
                    continue
                for e in range(start[base + a], start[base + b + 1]):
                    ex, ey, ez = bx[e] - fx, by[e] - fy, bz[e] - z
                    if around:
                        ex = wrapped(ex - half * dx, lengths[0]) + half * dx
                        ey = wrapped(ey - half * dy, lengths[1]) + half * dy
                    along = ex * dx + ey * dy + ez * dz
                    if (
                        along > 0
                        and along < d2
                        and (ex * ex + ey * ey + ez * ez - br[e] * br[e]) * d2 < along * along
                    ):
                        if bu[e] != me and bu[e] != it:
                            return True
    return False


@njit
def nearest_visible(first, last, seekers, targets, space, bodies, sight, ground, found):
    """Replace each seeker's nearest target with the nearest target in the field of view that is not hidden by
    a body, rock or hill (−1: none).

    Seekers without a target in reach are not changed. This is a kernel over seekers first … last − 1.
    """
    ox, oy, oz, ou, cos, sin = seekers
    _, tx, ty, tz, tu, _ = targets
    target, distance2 = found
    close = np.empty(tx.size, np.int64)
    uneven = ground.kind.size > 1 or ground.height.size > 1
    for i in range(first, last):
        if target[i] < 0:
            continue
        x, y, z = ox[i], oy[i], oz[i]
        best, best_j = sight.radius * sight.radius, -1
        j = target[i]
        dx, dy, dz = offset(x, y, z, tx[j], ty[j], tz[j], space)
        view = of_row(sight.cos_half_fov, i)
        if ahead(dx, dy, dz, cos[i], sin[i], view) and not (
            sight.occlusion
            and (
                hidden(x, y, z, dx, dy, dz, ou[i], tu[j], bodies, space)
                or (uneven and behind_ground(x, y, dx, dy, i, j, sight, ground, space))
            )
        ):
            continue
        n_close = gather(x, y, z, sight.reach, targets, space, close)
        for c in range(n_close):
            e = close[c]
            if tu[e] == ou[i]:
                continue
            dx, dy, dz = offset(x, y, z, tx[e], ty[e], tz[e], space)
            d2 = dx * dx + dy * dy + dz * dz
            if d2 >= best or not ahead(dx, dy, dz, cos[i], sin[i], view):
                continue
            if sight.occlusion and (
                hidden(x, y, z, dx, dy, dz, ou[i], tu[e], bodies, space)
                or (uneven and behind_ground(x, y, dx, dy, i, e, sight, ground, space))
            ):
                continue
            best, best_j = d2, e
        target[i] = best_j
        distance2[i] = best


@njit
def behind_ground(x, y, dx, dy, i, j, sight, ground, space):
    """Return whether a rock or hill hides target j, at displacement (dx, dy), from seeker i."""
    eye, top = of_row(sight.eye, i), of_row(sight.top, j)
    return rock_between(x, y, dx, dy, ground, space) <= 1 or hill_between(
        x, y, dx, dy, eye, top, ground, space
    )


@njit
def ahead(dx, dy, dz, cos, sin, cos_half_fov):
    """Return whether a direction lies in the field of view around the heading."""
    if cos_half_fov <= np.float32(-1.0):
        return True
    return dx * cos + dy * sin >= cos_half_fov * np.sqrt(dx * dx + dy * dy + dz * dz)


@njit
def count_ahead(first, last, seekers, radius, cos_half_fov, targets, reach, space, count):
    """Write to `count` i32[n] the number of targets within each seeker's `radius` f32[n] [m] and field of view,
    hidden or not. `reach` is in cells."""
    x, y, z, uid, cos, sin = seekers
    near = np.empty(targets.x.size, np.int64)
    for i in range(first, last):
        view, count[i] = of_row(cos_half_fov, i), 0
        for q in range(gather(x[i], y[i], z[i], reach, targets, space, near)):
            j = near[q]
            dx, dy, dz = offset(x[i], y[i], z[i], targets.x[j], targets.y[j], targets.z[j], space)
            inside = dx * dx + dy * dy + dz * dz <= radius[i] * radius[i] and targets.uid[j] != uid[i]
            count[i] += inside and ahead(dx, dy, dz, cos[i], sin[i], view)


@njit
def cast(
    first: int,
    last: int,
    seekers: Poses,
    bodies: Spheres,
    rays: Rays,
    reach: int,
    ground: Ground,
    space: Extent,
) -> None:
    """Write, for each seeker and ray, the kind of the first body hit within the rays' radius (−1 none, −2
    rock or wall) and its distance. Rays start at the seekers' positions; `reach` is in cells."""
    ox, oy, oz, ou, cos, sin = seekers
    bx, by, bz, br, bu, bkind, _, _ = bodies
    ray_cos, ray_sin, radius, eye, hit, distance = rays
    lengths, torus, n_rays = space.lengths, space.torus, ray_cos.shape[-1]
    near = np.empty(bx.size, np.int64)
    ux, uy, best, way = np.empty((4, n_rays), np.float32)
    narrow = min(lengths[0], lengths[1]) if torus else np.float32(np.inf)
    for i in range(first, last):
        x, y, z = ox[i], oy[i], oz[i]
        n = gather(x, y, z, reach, bodies, space, near)
        to_cos, to_sin = row_of(ray_cos, i), row_of(ray_sin, i)
        for r in range(n_rays):
            ux[r] = cos[i] * to_cos[r] - sin[i] * to_sin[r]
            uy[r] = sin[i] * to_cos[r] + cos[i] * to_sin[r]
            best[r], hit[i, r] = radius, -1
        for q in range(n):
            e = near[q]
            dx, dy, dz = offset(x, y, z, bx[e], by[e], bz[e], space)
            d2, most = dx * dx + dy * dy + dz * dz, radius + br[e]
            if bu[e] == ou[i] or d2 > np.float32(1.001) * most * most:
                continue
            # on a torus, the next images of a body may also be in reach
            for image in range(4 if most + most > narrow else 1):
                ax = dx - np.copysign(lengths[0], dx) if image % 2 else dx
                ay = dy - np.copysign(lengths[1], dy) if image > 1 else dy
                d2 = ax * ax + ay * ay + dz * dz
                if not ways(ax, ay, d2, br[e] * br[e], ux, uy, best, way) or hill_between(
                    x, y, ax, ay, eye[i], 2 * br[e], ground, space
                ):
                    continue
                for r in range(n_rays):
                    if way[r] < best[r]:
                        best[r], hit[i, r] = way[r], bkind[e]
        for r in range(n_rays):
            distance[i, r] = best[r]
            rock = radius * rock_between(x, y, ux[r] * radius, uy[r] * radius, ground, space)
            if rock < distance[i, r]:
                distance[i, r], hit[i, r] = rock, -2
            if not torus:
                wall = wall_ahead(x, y, ux[r], uy[r], lengths)
                if wall < distance[i, r]:
                    distance[i, r], hit[i, r] = wall, -2


@njit
def ways(dx, dy, d2, r2, ux, uy, best, way):
    """Write how far along each ray the sphere at (dx, dy) begins: 0 inside the sphere, infinite if the ray
    misses it. Return whether any distance is shorter than `best`. `d2` is the squared distance [m²], `r2` the
    squared radius."""
    if d2 <= r2:
        way[:] = 0
        return True
    nearer = 0
    for r in range(way.size):
        along = dx * ux[r] + dy * uy[r]
        inside = r2 - (d2 - along * along)
        meets = along > np.float32(0.0) and inside > np.float32(0.0)
        begins = max(along - np.sqrt(max(inside, np.float32(0.0))), np.float32(0.0))
        way[r] = begins if meets else np.float32(np.inf)
        nearer |= way[r] < best[r]
    return nearer != 0


@njit
def wall_ahead(x, y, ux, uy, lengths):
    """Return the distance [m] to the edge of the space in a given direction."""
    wall = np.float32(np.inf)
    if ux > 0:
        wall = min(wall, (lengths[0] - x) / ux)
    elif ux < 0:
        wall = min(wall, -x / ux)
    if uy > 0:
        wall = min(wall, (lengths[1] - y) / uy)
    elif uy < 0:
        wall = min(wall, -y / uy)
    return wall
