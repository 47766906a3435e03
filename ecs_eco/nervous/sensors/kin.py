"""Kin sensing: which nearby bodies are the organism's mother, father, child or sibling, and which relative is
nearest to a point on the body."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Parentage
from ecs_eco.space.geometry import Extent
from ecs_eco.space.index import Entries, Index
from ecs_eco.space.nearest import Found
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.sight import Poses, gather, offset
from ecs_eco.space.sums import LINEAR, NONE, TOUCHING2, Looking, Sums, Weighed

if TYPE_CHECKING:
    from collections.abc import Callable

    from ecs_eco.engine.table import Table

MOTHER, FATHER, OFFSPRING, SIBLINGS, ANYBODY = 0, 1, 2, 3, 4
RELATIONS = {"mother": MOTHER, "father": FATHER, "offspring": OFFSPRING, "siblings": SIBLINGS, None: ANYBODY}
NOBODY = np.zeros(0, np.uint64)


class Kin(NamedTuple):
    """Parentage, for kernels: uids u64[n]; the parents' uids are empty if the table has none."""

    uid: np.ndarray
    mother: np.ndarray
    father: np.ndarray


def kin_of(table: Table, rows: np.ndarray, uid: np.ndarray) -> Kin:
    """Return the uids of rows i64[n], of their mothers and of their fathers."""
    if Parentage not in table:
        return Kin(uid, NOBODY, NOBODY)
    p = table[Parentage]
    return Kin(uid, p.mother[rows], p.father[rows])


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
) -> Found:
    """Return the entry i32[n] (−1: none) of the relative nearest to each seeker's position x, y, z f32[n]
    [m], and the squared distance f32[n] [m²]. Without a relation, any member counts. The search is limited to
    the distance `own` f32[n] [m] and the field of view; ties go to the lower uid.
    """
    found = Found(np.full(seekers.n, -1, np.int32), np.full(seekers.n, np.inf, np.float32))
    if seekers.n and targets.n:
        split(
            _nearest,
            seekers.n,
            seekers.poses_at(*places),
            own,
            kin_of(table, seekers.rows, seekers.index.uid),
            targets.entries,
            kin_of(other, targets.rows, targets.uid),
            RELATIONS[relation],
            targets.space.reach(float(own.max())),
            targets.space.extent,
            cos_half_fov,
            found,
        )
    return found


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
    """Like `add_near` of ecs_eco.space.sums, but for relatives only."""
    if seekers.n and targets.n:
        split(
            _add,
            seekers.n,
            Looking._make((*places, own)),
            kin_of(table, seekers.rows, seekers.index.uid),
            targets.entries,
            kin_of(other, targets.rows, targets.uid),
            RELATIONS[relation],
            targets.space.reach(float(own.max())),
            targets.space.extent,
            Weighed(value, size, decay),
            Sums(total, weight),
        )


@njit
def related(relation, mine, i, its, j):
    """Return whether the organism at j has the given relation to the one at i."""
    uid, mother, father = mine
    its_uid, its_mother, its_father = its
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
    first: int,
    last: int,
    seekers: Poses,
    radius: np.ndarray,
    mine: Kin,
    targets: Entries,
    theirs: Kin,
    relation: int,
    reach: int,
    space: Extent,
    cos_half_fov: Number,
    found: Found,
) -> None:
    x, y, z, _, cos, sin = seekers
    _, tx, ty, tz, its_uid, _ = targets
    entries, distance2 = found
    near = np.empty(tx.size, np.int64)
    for i in range(first, last):
        n = gather(x[i], y[i], z[i], reach, targets, space, near)
        view = of_row(cos_half_fov, i)
        for q in range(n):
            j = near[q]
            if not related(relation, mine, i, theirs, j):
                continue
            dx, dy, dz = offset(x[i], y[i], z[i], tx[j], ty[j], tz[j], space)
            d2, best = dx * dx + dy * dy + dz * dz, entries[i]
            if d2 > radius[i] * radius[i] or (view > -1 and dx * cos[i] + dy * sin[i] < view * np.sqrt(d2)):
                continue
            if best < 0 or d2 < distance2[i] or (d2 == distance2[i] and its_uid[j] < its_uid[best]):
                entries[i], distance2[i] = j, d2


@njit
def _add(
    first: int,
    last: int,
    looking: Looking,
    mine: Kin,
    targets: Entries,
    theirs: Kin,
    relation: int,
    reach: int,
    space: Extent,
    weighed: Weighed,
    out: Sums,
) -> None:
    x, y, z, radius = looking
    tx, ty, tz, (value, size, decay) = targets.x, targets.y, targets.z, weighed
    near = np.empty(tx.size, np.int64)
    for i in range(first, last):
        n = gather(x[i], y[i], z[i], reach, targets, space, near)
        for q in range(n):
            j = near[q]
            if not related(relation, mine, i, theirs, j):
                continue
            dx, dy, dz = offset(x[i], y[i], z[i], tx[j], ty[j], tz[j], space)
            d2 = dx * dx + dy * dy + dz * dz
            if d2 >= radius[i] * radius[i]:
                continue
            w = np.float32(1.0)
            if decay == LINEAR:
                w -= np.sqrt(d2) / radius[i]
            elif decay != NONE:
                w /= max(d2, size[j] * size[j], np.float32(TOUCHING2))
            out.total[i] += value[j] * w
            out.weight[i] += w
