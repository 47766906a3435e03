"""Sensing of kin: which bodies nearby are the organism's own mother, father, child or sibling, and the
nearest of any relation to a place on the body."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import of_row
from ecs_eco.components import Parentage
from ecs_eco.space.index import Index
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.sight import gather, offset
from ecs_eco.space.sums import LINEAR, NONE, TOUCHING2

if TYPE_CHECKING:
    from collections.abc import Callable

    from ecs_eco.compiled.per_row import Number
    from ecs_eco.engine.table import Table

MOTHER, FATHER, OFFSPRING, SIBLINGS, ANYBODY = 0, 1, 2, 3, 4
RELATIONS = {"mother": MOTHER, "father": FATHER, "offspring": OFFSPRING, "siblings": SIBLINGS, None: ANYBODY}
NOBODY = np.zeros(0, np.uint64)


def parents(table: Table, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the uids of the mothers and fathers of rows i64[n]: u64[n], empty if the table has none."""
    if Parentage not in table:
        return NOBODY, NOBODY
    p = table[Parentage]
    return p.mother[rows], p.father[rows]


def nearest_kin(
    seekers: Seekers,
    table: Table,
    other: Table,
    targets: Index,
    relation: str | None,
    places: tuple[np.ndarray, ...],
    own: np.ndarray,
    cos_half_fov: Number,
    split: Callable[..., None],
) -> tuple[np.ndarray, np.ndarray]:
    """Return the entry of each seeker's nearest relative (without a relation: of the nearest member) to its
    place x, y, z f32[n] [m], −1 for none, and its squared distance: i32[n], f32[n] [m²].

    The search covers `own` f32[n] [m] and the field of view; ties go to the lower uid.
    """
    entries, distance2 = np.full(seekers.n, -1, np.int32), np.full(seekers.n, np.inf, np.float32)
    if seekers.n and targets.n:
        space = targets.space
        split(
            _nearest,
            seekers.n,
            *places,
            seekers.index.uid,
            seekers.cos,
            seekers.sin,
            own,
            *parents(table, seekers.rows),
            targets.x,
            targets.y,
            targets.z,
            targets.uid,
            *parents(other, targets.rows),
            targets.start,
            RELATIONS[relation],
            space.reach(float(own.max())),
            *space.shape,
            space.inverse,
            space.lengths,
            space.torus,
            cos_half_fov,
            entries,
            distance2,
        )
    return entries, distance2


def add_kin(
    seekers: Seekers,
    table: Table,
    other: Table,
    targets: Index,
    relation: str,
    places: tuple[np.ndarray, ...],
    own: np.ndarray,
    value: np.ndarray,
    size: np.ndarray,
    decay: int,
    total: np.ndarray,
    weight: np.ndarray,
    split: Callable[..., None],
) -> None:
    """Do the same as `add_near` of ecs_eco.space.sums, for relatives only."""
    if seekers.n and targets.n:
        space = targets.space
        split(
            _add,
            seekers.n,
            *places,
            seekers.index.uid,
            own,
            *parents(table, seekers.rows),
            targets.x,
            targets.y,
            targets.z,
            targets.uid,
            *parents(other, targets.rows),
            targets.start,
            RELATIONS[relation],
            space.reach(float(own.max())),
            *space.shape,
            space.inverse,
            space.lengths,
            space.torus,
            value,
            size,
            decay,
            total,
            weight,
        )


@njit
def related(relation, uid, mother, father, i, its_uid, its_mother, its_father, j):
    """Return whether the organism at j has the given relation to the one at i."""
    it = its_uid[j]
    if it == uid[i]:
        return False
    if relation == ANYBODY:
        return True
    if relation == MOTHER:
        return mother.size > 0 and mother[i] == it
    if relation == FATHER:
        return father.size > 0 and father[i] == it
    if its_mother.size == 0:
        return False
    if relation == OFFSPRING:
        return its_mother[j] == uid[i] or its_father[j] == uid[i]
    return mother.size > 0 and (
        (mother[i] != 0 and mother[i] == its_mother[j]) or (father[i] != 0 and father[i] == its_father[j])
    )


@njit
def _nearest(
    first,
    last,
    x,
    y,
    z,
    uid,
    cos,
    sin,
    radius,
    mother,
    father,
    tx,
    ty,
    tz,
    its_uid,
    its_mother,
    its_father,
    start,
    relation,
    reach,
    nx,
    ny,
    nz,
    inverse,
    lengths,
    torus,
    cos_half_fov,
    entries,
    distance2,
):
    near = np.empty(tx.size, np.int64)
    for i in range(first, last):
        n = gather(x[i], y[i], z[i], reach, start, tx, ty, tz, nx, ny, nz, inverse, lengths, torus, near)
        view = of_row(cos_half_fov, i)
        for q in range(n):
            j = near[q]
            if not related(relation, uid, mother, father, i, its_uid, its_mother, its_father, j):
                continue
            dx, dy, dz = offset(x[i], y[i], z[i], tx[j], ty[j], tz[j], lengths, torus)
            d2, best = dx * dx + dy * dy + dz * dz, entries[i]
            if d2 > radius[i] * radius[i] or (view > -1 and dx * cos[i] + dy * sin[i] < view * np.sqrt(d2)):
                continue
            if best < 0 or d2 < distance2[i] or (d2 == distance2[i] and its_uid[j] < its_uid[best]):
                entries[i], distance2[i] = j, d2


@njit
def _add(
    first,
    last,
    x,
    y,
    z,
    uid,
    radius,
    mother,
    father,
    tx,
    ty,
    tz,
    its_uid,
    its_mother,
    its_father,
    start,
    relation,
    reach,
    nx,
    ny,
    nz,
    inverse,
    lengths,
    torus,
    value,
    size,
    decay,
    total,
    weight,
):
    near = np.empty(tx.size, np.int64)
    for i in range(first, last):
        n = gather(x[i], y[i], z[i], reach, start, tx, ty, tz, nx, ny, nz, inverse, lengths, torus, near)
        for q in range(n):
            j = near[q]
            if not related(relation, uid, mother, father, i, its_uid, its_mother, its_father, j):
                continue
            dx, dy, dz = offset(x[i], y[i], z[i], tx[j], ty[j], tz[j], lengths, torus)
            d2 = dx * dx + dy * dy + dz * dz
            if d2 >= radius[i] * radius[i]:
                continue
            w = np.float32(1.0)
            if decay == LINEAR:
                w -= np.sqrt(d2) / radius[i]
            elif decay != NONE:
                w /= max(d2, size[j] * size[j], np.float32(TOUCHING2))
            total[i] += value[j] * w
            weight[i] += w
