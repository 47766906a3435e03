import itertools

import numpy as np
import pytest

from ecs_eco.space import Index, Space
from ecs_eco.space.sums import DECAYS, add_near

CASES = list(
    itertools.product(
        [((50, 40), 1.0), ((12, 9), 4.4), ((12, 9), 2.0), ((9, 30, 3), 2.0)],
        ["torus", "walls"],
        [1.0, 4.4],
        [0.0, 0.7],
        DECAYS,
    )
)


def _index(space, n, rng):
    places = (rng.random((n, 3)) * [*space.size, 0][:3]).astype(np.float32)
    index = Index(space)
    index.build(
        np.ones(n, np.bool_),
        *(places[:, i].copy() for i in range(3)),
        (rng.permutation(n) + 1).astype(np.uint64),
    )
    return index


def _slow(space, places, radius, targets, value, size, decay, same):
    """Every pair of places and bodies."""
    d = np.stack([targets.x, targets.y, targets.z], 1)[None].astype(float) - np.stack(places, 1)[:, None]
    if space.torus:
        for axis in range(2):
            d[..., axis] -= space.size[axis] * np.round(d[..., axis] / space.size[axis])
    d = np.sqrt((d**2).sum(-1))
    weight = {
        "none": np.ones_like(d),
        "linear": 1 - d / radius[:, None],
        "inverse_square": 1 / np.maximum(d, size[None]) ** 2,
    }[decay]
    weight = np.where((d < radius[:, None]) & ~(same & np.eye(*d.shape, dtype=bool)), weight, 0)
    return weight @ value.astype(float), weight.sum(1)


@pytest.mark.parametrize(("world", "edges", "radius", "off", "decay"), CASES)
def test_sums_are_those_of_all_pairs(world, edges, radius, off, decay):
    rng, (size, cell) = np.random.default_rng(1), world
    space = Space(size, edges, cell)
    few, many = _index(space, 40, rng), _index(space, 150, rng)
    for seekers, targets in ((few, many), (many, many), (many, few)):
        way = rng.random(seekers.n) * 6.28
        x, y = seekers.x + off * np.cos(way), seekers.y + off * np.sin(way)
        x, y = (v % s if space.torus else v.clip(0, s) for v, s in ((x, space.size[0]), (y, space.size[1])))
        places = (x.astype(np.float32), y.astype(np.float32), seekers.z)
        own = rng.uniform(radius / 2, radius, seekers.n).astype(np.float32)
        value, body = (rng.uniform(low, 1.0, targets.n).astype(np.float32) for low in (-1.0, 0.1))
        total, weight = np.full(seekers.n, 5.0), np.zeros(seekers.n)
        add_near(seekers, places, own, targets, value, body, DECAYS[decay], total, weight)
        expected = _slow(space, places, own, targets, value, body, decay, seekers is targets)
        assert total - 5 == pytest.approx(expected[0], rel=1e-4, abs=2e-4)
        assert weight == pytest.approx(expected[1], rel=1e-4, abs=2e-4)


def test_nobody_to_look_for_or_nobody_who_looks_adds_nothing():
    space = Space((9.0, 9.0), "torus", 2.0)
    rng = np.random.default_rng(2)
    nobody, some = _index(space, 0, rng), _index(space, 5, rng)
    for seekers, targets in ((nobody, some), (some, nobody)):
        total = np.zeros(seekers.n)
        each = np.ones(targets.n, np.float32)
        add_near(
            seekers,
            (seekers.x, seekers.y, seekers.z),
            np.full(seekers.n, 2.0, np.float32),
            targets,
            each,
            each,
            0,
            total,
            total.copy(),
        )
        assert not total.any()


def test_points_at_the_same_place_are_no_division_by_zero():
    space = Space((9.0, 9.0), "torus", 2.0)
    index = Index(space)
    x = np.full(2, 3.0, np.float32)
    index.build(np.ones(2, np.bool_), x, x, np.zeros(2, np.float32), np.array([1, 2], np.uint64))
    total, weight = np.zeros(2), np.zeros(2)
    add_near(
        index,
        (index.x, index.y, index.z),
        x,
        index,
        np.ones(2, np.float32),
        np.zeros(2, np.float32),
        DECAYS["inverse_square"],
        total,
        weight,
    )
    assert total == pytest.approx([1e12, 1e12])


@pytest.mark.parametrize("decay", DECAYS)
def test_sums_have_the_same_bits_however_the_work_is_split(decay):
    rng, space = np.random.default_rng(4), Space((30.0, 20.0, 25.0), "torus", 4.4)
    index = _index(space, 400, rng)
    own = rng.uniform(2.0, 9.0, index.n).astype(np.float32)
    value, body = (rng.random(index.n).astype(np.float32) for _ in range(2))

    def row_by_row(kernel, n, *arguments, work):
        assert work == index.n
        for row in reversed(range(n)):
            kernel(row, row + 1, *arguments)

    results = []
    for split in (None, row_by_row):
        total, weight = np.zeros(index.n), np.zeros(index.n)
        add_near(
            index, (index.x, index.y, index.z), own, index, value, body, DECAYS[decay], total, weight, split
        )
        results.append(total.tobytes() + weight.tobytes())
    assert results[0] == results[1]
