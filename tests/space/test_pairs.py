import itertools

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Body, Position
from ecs_eco.space import Index, Space
from ecs_eco.space.pairs import pairs, radii

CASES = list(
    itertools.product(
        [(50, 40), (30, 20, 25), (12, 9)], ["torus", "walls"], [1.0, 4.4, 30.0], [1.0, 4.0, 50.0]
    )
)


def _world(size=(50.0, 40.0), edges="torus", cell=4.0, threads=1, n=(150, 300)):
    world = World(size, edges=edges, cell=cell, seed=1, threads=threads)
    rng = np.random.default_rng(1)
    for name, k in zip("ab", n, strict=True):
        world.add_table(name, Position, Body)
        for place in rng.uniform(0, size, (k, len(size))):
            world.spawn(name, Position(**dict(zip("xyz", map(float, place), strict=False))))
    world.flush()
    return world


def _places(table):
    p = table[Position]
    return np.stack([p.x, p.y, p.z], 1).astype(float)


def _distances(world, a, b):
    d = b[None] - a[:, None]
    if world.space.torus:
        for axis in range(2):
            d[..., axis] -= world.space.size[axis] * np.round(d[..., axis] / world.space.size[axis])
    return np.sqrt((d**2).sum(-1))


@pytest.mark.parametrize(("size", "edges", "radius", "cell"), CASES)
def test_pairs_are_those_of_all_closer_than_the_radius(size, edges, radius, cell):
    world = _world(size, edges, cell)
    for one, other in ("ab", "ba", "aa"):
        a, b = world.table(one), world.table(other)
        found = world.pairs(one, other, radius)
        d = _distances(world, _places(a)[: a.high], _places(b)[: b.high])
        if a is b:
            np.fill_diagonal(d, np.inf)
        got = np.full(d.shape, np.inf)
        got[found.rows, found.others] = found.distance
        assert len(found.rows) == np.isfinite(got).sum() > 0  # no pair twice
        sure = np.abs(d - radius) > 1e-4  # else rounding decides
        assert np.allclose(np.where(d < radius, d, np.inf)[sure], got[sure], atol=1e-4)


def test_hand_counted_pairs_across_the_seam():
    world = World((10.0, 10.0), cell=2.0)
    world.add_table("a", Position, Body)
    for x in (0.5, 9.0, 5.0):
        world.spawn("a", Position(x=x, y=5.0))
    world.flush()
    a = world.table("a")
    one, other, distance = world.pairs("a", "a", 2.0)
    x = a[Position].x
    assert sorted(zip(x[one], x[other], distance, strict=True)) == [(0.5, 9.0, 1.5), (9.0, 0.5, 1.5)]
    assert world.pairs("a", "a", 1.5).rows.size == 0  # closer than the radius
    places, rows, distance = world.within("a", [[9.5, 5.0], [4.0, 5.0], [-9.5, 5.0]], 1.25)
    assert [(int(p), float(x[r]), float(d)) for p, r, d in zip(places, rows, distance, strict=True)] == [
        (0, 9.0, 0.5),
        (0, 0.5, 1.0),
        (1, 5.0, 1.0),
        (2, 0.5, 0.0),
    ]
    one, other, distance = world.nearest("a", "a")
    assert dict(zip(x[one].tolist(), x[other].tolist(), strict=True)) == {0.5: 9.0, 9.0: 0.5, 5.0: 9.0}
    assert world.nearest("a", "a", 2.0).rows.size == 2


def test_a_radius_may_be_each_ones_own():
    world = _world()
    a = world.table("a")
    radius = np.full(a.capacity, 3.0, np.float32)
    radius[a.rows()[:10]] = 9.0
    wide, narrow = world.pairs("a", "b", 9.0), world.pairs("a", "b", 3.0)
    own = world.pairs(a, world.table("b"), radius)
    assert len(narrow.rows) < len(own.rows) < len(wide.rows)
    few = set(a.rows()[:10].tolist())
    wanted = [p for p in zip(*wide, strict=True) if p[0] in few] + [
        p for p in zip(*narrow, strict=True) if p[0] not in few
    ]
    assert sorted(zip(*own, strict=True)) == sorted(wanted)
    places = np.stack([a[Position].x[a.rows()], a[Position].y[a.rows()]], 1)
    by_place = world.within("b", places, radius[a.rows()])
    assert sorted(zip(a.rows()[by_place.rows], by_place.others, strict=True)) == sorted(
        zip(own.rows, own.others, strict=True)
    )


def _uids_near(places, uid, split=None):
    index = Index(Space((50.0, 40.0), cell=2.0))
    index.build(np.ones(len(uid), np.bool_), *(np.ascontiguousarray(v) for v in places.T), uid)
    found = pairs((index.x, index.y, index.z), index.rows, radii(1.0, index.n), index, True, split)
    return uid[found.rows], uid[found.others], found.distance


def test_the_order_is_that_of_places_and_uids_and_not_of_rows_or_parts():
    rng = np.random.default_rng(2)
    places = (rng.random((3000, 3)) * (50, 40, 0)).astype(np.float32)
    uid, order = np.arange(1, 3001, dtype=np.uint64), rng.permutation(3000)

    def in_parts(kernel, n, *arguments, work):
        for first in range(0, n, 700):
            kernel(first, min(first + 700, n), *arguments)

    once = _uids_near(places, uid)
    assert len(once[0]) > 3000
    for other in (_uids_near(places[order], uid[order]), _uids_near(places, uid, in_parts)):
        assert all((x == y).all() for x, y in zip(once, other, strict=True))


def test_pairs_of_the_empty_are_none():
    world = _world(n=(0, 5))
    for found in (
        world.pairs("a", "b", 3.0),
        world.pairs("b", "a", 3.0),
        world.nearest("a", "b"),
        world.within("b", np.empty((0, 2)), 1.0),
        world.pairs("b", "b", 0.0),
    ):
        assert [len(part) for part in found] == [0, 0, 0]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda w: w.pairs("a", "c", 1.0), "'c'"),
        (lambda w: w.pairs("a", "b", -1.0), r"radius is -1.0; expected at least 0 m"),
        (lambda w: w.pairs("a", "b", np.nan), r"radius is nan; expected at least 0 m"),
        (
            lambda w: w.pairs("a", "b", np.ones(3)),
            r"radius: an array of shape \(3,\); expected a number, or \(150,\)",
        ),
        (lambda w: w.within("a", [[1.0, 2.0]], [1.0, 2.0]), r"shape \(2,\); expected a number, or \(1,\)"),
        (lambda w: w.within("a", [1.0, 2.0], 1.0), r"shape \(2,\); expected \(n, 2\): x, y of each"),
        (lambda w: w.within("a", [[1.0, np.inf]], 1.0), r"places\[0\].y is inf; expected finite numbers"),
        (lambda w: w.within("a", [[1.0, 2.0], [1.0, 41.0]], 1.0), r"places\[1\].y is 41; expected 0 to 40 m"),
    ],
)
def test_what_cannot_be_is_refused(call, message):
    with pytest.raises((ValueError, KeyError), match=message):
        call(_world(edges="walls"))
