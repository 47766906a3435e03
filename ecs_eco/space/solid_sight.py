"""Sight among capsules and boxes: rays that hit them, lines of sight that they block, and the nearest body of
a kind, with distance measured to its nearest point."""

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import of_row, row_of
from ecs_eco.space.geometry import Extent, Places
from ecs_eco.space.nearest import Found
from ecs_eco.space.shapes import image_of, nearest_on, ray
from ecs_eco.space.sight import Poses, Rays, Sight, ahead, hidden, rock_between
from ecs_eco.space.solids import Solids, around
from ecs_eco.space.spheres import Spheres
from ecs_eco.space.terrain import Ground, hill_between


@njit
def meets(form, e, x, y, z, wx, wy, wz, space):
    """Return the share of the displacement (wx, wy, wz) from (x, y, z) at which body e begins; infinite if
    the line misses it."""
    images, best = 2 if space.torus else 1, np.inf
    dx, dy, dz = x - form[e, 0], y - form[e, 1], z - form[e, 2]
    for image in range(images * images):
        ax, ay = image_of(dx, dy, space, image)
        best = min(best, ray(form, e, ax, ay, dz, wx, wy, wz))
    return best


@njit
def cut(x, y, z, wx, wy, wz, me, it, solids, space, seen, near):
    """Return whether a capsule or box other than `me` and `it` lies across the displacement (wx, wy, wz) from
    (x, y, z); `seen` and `near` are scratch arrays for `around`."""
    form, uid = solids.form, solids.uid
    n = around(
        x + wx / 2, y + wy / 2, z + wz / 2, abs(wx) / 2, abs(wy) / 2, abs(wz) / 2, solids, space, seen, near
    )
    for q in range(n):
        e = near[q]
        if uid[e] != me and uid[e] != it and meets(form, e, x, y, z, wx, wy, wz, space) < 1:
            return True
    return False


@njit
def cast_on_solids(
    first: int, last: int, seekers: Poses, solids: Solids, rays: Rays, ground: Ground, space: Extent
) -> None:
    """Replace the ray hits written by `sight.cast` with the capsules and boxes that the rays hit first."""
    ox, oy, oz, ou, cos, sin = seekers
    ray_cos, ray_sin, radius, eye, hit, distance = rays
    form, uid, kind = solids.form, solids.uid, solids.kind
    seen, near = np.zeros(len(form) + 1, np.int64), np.empty(len(form), np.int64)
    for i in range(first, last):
        x, y, z = np.float64(ox[i]), np.float64(oy[i]), np.float64(oz[i])
        n = around(x, y, z, radius, radius, 0.0, solids, space, seen, near)
        to_cos, to_sin = row_of(ray_cos, i), row_of(ray_sin, i)
        for r in range(to_cos.size):
            ux, uy = cos[i] * to_cos[r] - sin[i] * to_sin[r], sin[i] * to_cos[r] + cos[i] * to_sin[r]
            for q in range(n):
                e = near[q]
                if uid[e] == ou[i]:
                    continue
                t = np.float32(meets(form, e, x, y, z, ux, uy, 0.0, space))
                if t < distance[i, r] and not hill_between(
                    ox[i], oy[i], t * ux, t * uy, eye[i], top_of(form, e), ground, space
                ):
                    hit[i, r], distance[i, r] = kind[e], t


@njit
def top_of(form, e):
    """Return the height of body e [m]."""
    return np.float32(2 * (form[e, 5] + form[e, 6]))


@njit
def towards(form, e, x, y, z, limit, space):
    """Return the displacement from (x, y, z) to the nearest point of a body, and its squared length, infinite
    beyond `limit` [m]. The point is the center of a sphere, a point on the axis of a capsule, or a point in a
    box."""
    images = 2 if space.torus else 1
    best, wx, wy, wz = np.inf, 0.0, 0.0, 0.0
    dx, dy, dz = x - form[e, 0], y - form[e, 1], z - form[e, 2]
    h = np.float64(form[e, 5])
    rise = min(max(dz, -h), h) - dz if space.volume else 0.0
    for image in range(images * images):
        ax, ay = image_of(dx, dy, space, image)
        if abs(ax) == np.inf or abs(ay) == np.inf:
            continue
        px, py = nearest_on(form, e, ax, ay)
        d2 = (px - ax) ** 2 + (py - ay) ** 2 + rise * rise
        if d2 < best and d2 < limit * limit:
            best, wx, wy, wz = d2, px - ax, py - ay, rise
    return wx, wy, wz, best


@njit
def nearest_in_sight(
    first: int,
    last: int,
    seekers: Poses,
    targets: Solids,
    spheres: Spheres,
    solids: Solids,
    sight: Sight,
    ground: Ground,
    space: Extent,
    nearest: Places,
    found: Found,
) -> None:
    """Write, for each seeker, the nearest point of the nearest target in the field of view that no sphere,
    capsule, box, rock or hill hides. The entry written is the seeker's own index, or −1 if there is no
    target. `spheres` and `solids` are opaque."""
    ox, oy, oz, ou, cos, sin = seekers
    form, uid, radius, (target, distance2) = targets.form, targets.uid, sight.radius, found
    seen, near = np.zeros(len(form) + 1, np.int64), np.empty(len(form), np.int64)
    cutting, cutters = np.zeros(len(solids.form) + 1, np.int64), np.empty(len(solids.form), np.int64)
    for i in range(first, last):
        x, y, z, best = np.float64(ox[i]), np.float64(oy[i]), np.float64(oz[i]), np.float64(radius)
        target[i], distance2[i], best = -1, radius * radius, best * best
        n = around(x, y, z, radius, radius, radius, targets, space, seen, near)
        for q in range(n):
            e = near[q]
            if uid[e] == ou[i]:
                continue
            wx, wy, wz, d2 = towards(form, e, x, y, z, radius, space)
            if not (d2 < best and ahead(wx, wy, wz, cos[i], sin[i], of_row(sight.cos_half_fov, i))):
                continue
            if sight.occlusion:
                dx, dy, dz, top = np.float32(wx), np.float32(wy), np.float32(wz), top_of(form, e)
                if (
                    hidden(ox[i], oy[i], oz[i], dx, dy, dz, ou[i], uid[e], spheres, space)
                    or cut(x, y, z, wx, wy, wz, ou[i], uid[e], solids, space, cutting, cutters)
                    or rock_between(ox[i], oy[i], dx, dy, ground, space) <= 1
                    or hill_between(ox[i], oy[i], dx, dy, of_row(sight.eye, i), top, ground, space)
                ):
                    continue
            best, target[i], distance2[i] = d2, i, d2
            nearest.x[i], nearest.y[i], nearest.z[i] = x + wx, y + wy, z + wz
