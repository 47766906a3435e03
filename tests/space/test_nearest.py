import itertools

import numpy as np
import pytest

from ecs_eco.space import Index, Space
from ecs_eco.space.nearest import nearest


def _index(space, n, rng, clumped):
    lengths = np.array([*space.size, 0][:3])
    places = rng.random((n, 3)) * (lengths * 0.1 if clumped else lengths)
    p = places.astype(np.float32)
    uid = (rng.permutation(n) + 1).astype(np.uint64)
    index = Index(space)
    index.build(np.ones(n, np.bool_), *(p[:, i].copy() for i in range(3)), uid)
    return p.astype(float), index


def _slow(space, seekers, targets, same, radius):
    d = targets[None] - seekers[:, None]
    if space.torus:
        for axis in range(2):
            d[..., axis] -= space.size[axis] * np.round(d[..., axis] / space.size[axis])
    d2 = (d**2).sum(-1)
    if same:
        np.fill_diagonal(d2, np.inf)
    return np.where(d2 < radius**2, d2, np.inf)


CASES = list(
    itertools.product(
        [(50, 40), (30, 20, 25), (12, 9), (9, 30, 3)],
        ["torus", "walls"],
        [2.0, 4.4],
        [1.0, 2.0, 4.0, 50.0],
        [False, True],
    )
)


@pytest.mark.parametrize(("size", "edges", "radius", "cell", "clumped"), CASES)
def test_the_nearest_is_that_of_all_pairs(size, edges, radius, cell, clumped):
    rng = np.random.default_rng(1)
    space = Space(size, edges, cell)
    (a, few), (b, many) = _index(space, 40, rng, clumped), _index(space, 150, rng, clumped)
    for p, seekers, q, targets in ((a, few, b, many), (b, many, b, many), (b, many, a, few)):
        target, distance2 = np.empty(seekers.n, np.int32), np.empty(seekers.n, np.float32)
        nearest(seekers, targets, radius, target, distance2)
        all_pairs = _slow(space, p, q, seekers is targets, radius)[seekers.rows]
        best = all_pairs.min(axis=1)
        assert ((target >= 0) == np.isfinite(best)).all()
        some = target >= 0
        chosen = all_pairs[some, targets.rows[target[some]]]
        # which one of equals, is a matter of rounding
        assert np.allclose(chosen, best[some], rtol=1e-5, atol=1e-6)
        assert np.allclose(distance2[some], best[some], rtol=1e-4, atol=1e-5)
        assert (distance2[~some] == np.float32(radius * radius)).all()


def test_hand_counted_neighbours_across_the_seam():
    space = Space((10, 10), "torus", 2.0)

    def at(*x):
        index = Index(space)
        index.build(
            np.ones(len(x), np.bool_),
            np.array(x, np.float32),
            np.full(len(x), 5, np.float32),
            np.zeros(len(x), np.float32),
            np.arange(1, len(x) + 1, dtype=np.uint64),
        )
        return index

    seekers, targets = at(0.5, 5.0, 9.5), at(9.0, 1.0)
    target, distance2 = np.empty(3, np.int32), np.empty(3, np.float32)
    nearest(seekers, targets, 2.0, target, distance2)
    assert targets.uid[target[[0, 2]]].tolist() == [2, 1]
    assert target[1] == -1
    assert distance2.tolist() == [0.25, 4.0, 0.25]


def test_nobody_is_its_own_nearest_and_the_empty_find_nothing():
    space = Space((10, 10), "walls", 2.0)
    one, none = Index(space), Index(space)
    p = np.ones(1, np.float32)
    one.build(np.ones(1, np.bool_), p, p, p * 0, np.ones(1, np.uint64))
    none.build(np.zeros(0, np.bool_), p[:0], p[:0], p[:0], np.zeros(0, np.uint64))
    target, distance2 = np.zeros(1, np.int32), np.zeros(1, np.float32)
    for targets in (one, none):
        nearest(one, targets, 3.0, target, distance2)
        assert (target[0], distance2[0]) == (-1, 9)
    nearest(none, one, 3.0, target[:0], distance2[:0])


def test_parts_find_what_the_whole_finds():
    space = Space((40, 40), "torus", 2.0)
    _, index = _index(space, 400, np.random.default_rng(3), False)
    whole, parts = [(np.empty(400, np.int32), np.empty(400, np.float32)) for _ in range(2)]
    nearest(index, index, 4.0, *whole)

    def split(kernel, n, *arguments, work):
        assert work == 800  # two for each that seeks
        for first in range(0, n, 3):
            kernel(first, min(first + 3, n), *arguments)

    nearest(index, index, 4.0, *parts, split)
    assert (whole[0] == parts[0]).all()
    assert (whole[1] == parts[1]).all()
