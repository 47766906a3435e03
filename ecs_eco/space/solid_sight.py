"""Sight among capsules and boxes: rays that meet them, lines that they cut, and the nearest body of a
kind, measured to its nearest point."""

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import of_row, row_of
from ecs_eco.space.shapes import nearest_on, ray, shift_to
from ecs_eco.space.sight import ahead, hidden, rock_between
from ecs_eco.space.solids import around
from ecs_eco.space.terrain import hill_between


@njit
def meets(form, e, x, y, z, wx, wy, wz, lengths, torus):
    """Return the share of the displacement (wx, wy, wz) from (x, y, z) at which body e begins; infinite if
    it misses it."""
    images, best = 2 if torus else 1, np.inf
    dx, dy, dz = x - form[e, 0], y - form[e, 1], z - form[e, 2]
    for image in range(images * images):
        ax = shift_to(dx, lengths[0], np.float64(lengths[0]), image % 2) if torus else dx
        ay = shift_to(dy, lengths[1], np.float64(lengths[1]), image // 2) if torus else dy
        best = min(best, ray(form, e, ax, ay, dz, wx, wy, wz))
    return best


@njit
def cut(
    x, y, z, wx, wy, wz, me, it, form, uid, nx, ny, nz, inverse, lengths, torus, start, entry, seen, near
):
    """Return whether a capsule or box lies across the displacement (wx, wy, wz) from (x, y, z), other than
    `me` and `it`; `seen` and `near` are those of `around`."""
    n = around(
        x + wx / 2,
        y + wy / 2,
        z + wz / 2,
        abs(wx) / 2,
        abs(wy) / 2,
        abs(wz) / 2,
        nx,
        ny,
        nz,
        inverse,
        lengths,
        torus,
        start,
        entry,
        seen,
        near,
    )
    for q in range(n):
        e = near[q]
        if uid[e] != me and uid[e] != it and meets(form, e, x, y, z, wx, wy, wz, lengths, torus) < 1:
            return True
    return False


@njit
def cast_on_solids(
    first,
    last,
    ox,
    oy,
    oz,
    ou,
    cos,
    sin,
    eye,
    form,
    uid,
    kind,
    nx,
    ny,
    nz,
    inverse,
    lengths,
    torus,
    start,
    entry,
    radius,
    ray_cos,
    ray_sin,
    ground_inverse,
    height,
    hit,
    distance,
):
    """Replace the hits of rays, as `sight.cast` writes them, by the capsules and boxes that they meet
    before."""
    seen, near = np.zeros(len(form) + 1, np.int64), np.empty(len(form), np.int64)
    for i in range(first, last):
        x, y, z = np.float64(ox[i]), np.float64(oy[i]), np.float64(oz[i])
        n = around(
            x, y, z, radius, radius, 0.0, nx, ny, nz, inverse, lengths, torus, start, entry, seen, near
        )
        to_cos, to_sin = row_of(ray_cos, i), row_of(ray_sin, i)
        for r in range(to_cos.size):
            ux, uy = cos[i] * to_cos[r] - sin[i] * to_sin[r], sin[i] * to_cos[r] + cos[i] * to_sin[r]
            for q in range(n):
                e = near[q]
                if uid[e] == ou[i]:
                    continue
                t = np.float32(meets(form, e, x, y, z, ux, uy, 0.0, lengths, torus))
                if t < distance[i, r] and not hill_between(
                    ox[i],
                    oy[i],
                    t * ux,
                    t * uy,
                    eye[i],
                    top_of(form, e),
                    height,
                    ground_inverse,
                    lengths,
                    torus,
                ):
                    hit[i, r], distance[i, r] = kind[e], t


@njit
def top_of(form, e):
    """Return the height of body e [m]."""
    return np.float32(2 * (form[e, 5] + form[e, 6]))


@njit
def towards(form, e, x, y, z, limit, lengths, torus, volume):
    """Return the displacement from (x, y, z) to the nearest point of a body, and its length squared;
    infinite beyond `limit` [m]. The point of a sphere is its center; of a capsule, it is on the axis; of a
    box, in the box."""
    images = 2 if torus else 1
    best, wx, wy, wz = np.inf, 0.0, 0.0, 0.0
    dx, dy, dz = x - form[e, 0], y - form[e, 1], z - form[e, 2]
    h = np.float64(form[e, 5])
    rise = min(max(dz, -h), h) - dz if volume else 0.0
    for image in range(images * images):
        ax = shift_to(dx, lengths[0], np.float64(lengths[0]), image % 2) if torus else dx
        ay = shift_to(dy, lengths[1], np.float64(lengths[1]), image // 2) if torus else dy
        if abs(ax) == np.inf or abs(ay) == np.inf:
            continue
        px, py = nearest_on(form, e, ax, ay)
        d2 = (px - ax) ** 2 + (py - ay) ** 2 + rise * rise
        if d2 < best and d2 < limit * limit:
            best, wx, wy, wz = d2, px - ax, py - ay, rise
    return wx, wy, wz, best


@njit
def nearest_in_sight(
    first,
    last,
    ox,
    oy,
    oz,
    ou,
    cos,
    sin,
    form,
    uid,
    tstart,
    tentry,
    occlusion,
    bx,
    by,
    bz,
    br,
    bu,
    bstart,
    largest,
    solid,
    solid_uid,
    sstart,
    sentry,
    nx,
    ny,
    nz,
    inverse,
    lengths,
    torus,
    volume,
    radius,
    cos_half_fov,
    ground,
    ground_inverse,
    height,
    eye,
    px,
    py,
    pz,
    target,
    distance2,
):
    """Write for each seeker the nearest point (px, py, pz)[i] [m] of the nearest target in the field of view
    that no sphere, capsule, box, rock or hill hides; target[i] is i, or −1 if there is none.

    `solid` are the opaque capsules and boxes, b… the opaque spheres.
    """
    seen, near = np.zeros(len(form) + 1, np.int64), np.empty(len(form), np.int64)
    cutting, cutters = np.zeros(len(solid) + 1, np.int64), np.empty(len(solid), np.int64)
    for i in range(first, last):
        x, y, z, best = np.float64(ox[i]), np.float64(oy[i]), np.float64(oz[i]), np.float64(radius)
        target[i], distance2[i], best = -1, radius * radius, best * best
        n = around(
            x, y, z, radius, radius, radius, nx, ny, nz, inverse, lengths, torus, tstart, tentry, seen, near
        )
        for q in range(n):
            e = near[q]
            if uid[e] == ou[i]:
                continue
            wx, wy, wz, d2 = towards(form, e, x, y, z, radius, lengths, torus, volume)
            if not (d2 < best and ahead(wx, wy, wz, cos[i], sin[i], of_row(cos_half_fov, i))):
                continue
            if occlusion:
                dx, dy, dz = np.float32(wx), np.float32(wy), np.float32(wz)
                if (
                    hidden(
                        ox[i],
                        oy[i],
                        oz[i],
                        dx,
                        dy,
                        dz,
                        ou[i],
                        uid[e],
                        largest,
                        bx,
                        by,
                        bz,
                        br,
                        bu,
                        bstart,
                        nx,
                        ny,
                        nz,
                        lengths,
                        torus,
                    )
                    or cut(
                        x,
                        y,
                        z,
                        wx,
                        wy,
                        wz,
                        ou[i],
                        uid[e],
                        solid,
                        solid_uid,
                        nx,
                        ny,
                        nz,
                        inverse,
                        lengths,
                        torus,
                        sstart,
                        sentry,
                        cutting,
                        cutters,
                    )
                    or rock_between(ox[i], oy[i], dx, dy, ground, ground_inverse, lengths, torus) <= 1
                    or hill_between(
                        ox[i], oy[i], dx, dy, eye[i], top_of(form, e), height, ground_inverse, lengths, torus
                    )
                ):
                    continue
            best, target[i], distance2[i] = d2, i, d2
            px[i], py[i], pz[i] = x + wx, y + wy, z + wz
