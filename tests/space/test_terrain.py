import numpy as np
import pytest

from ecs_eco.space import Space, Terrain
from ecs_eco.space.terrain import FENCE, OPEN, ROCK, WATER, cells_along, ground_at, height_at

F = np.float32


def test_rocks_and_lakes_are_discs_of_cells_that_wrap_around_a_torus():
    for edges, across in (("torus", ROCK), ("walls", OPEN)):
        terrain = Terrain(
            Space((20, 10), edges),
            1.0,
            rocks=[{"at": [0.0, 5.0], "radius": 2.0}],
            lakes=[{"at": [10.0, 5.0], "radius": 1.6}],
        )
        assert ground_at(terrain.maps, F(1.2), F(5.5)) == ROCK
        assert ground_at(terrain.maps, F(2.5), F(5.5)) == OPEN
        assert ground_at(terrain.maps, F(19.5), F(5.2)) == across
        assert ground_at(terrain.maps, F(9.1), F(4.4)) == WATER
        # cells whose centres lie within 1.6 of (10, 5): 4 at .71, 8 at 1.58
        assert (terrain.ground == WATER).sum() == 12


def test_free_is_open_ground():
    terrain = Terrain(Space((10, 10)), 1.0, rocks=[{"at": [5.0, 5.0], "radius": 2.0}])
    assert terrain.free(np.array([5.0, 1.0, 9.9999], F), np.array([5.0, 1.0, 9.9999], F)).tolist() == [
        False,
        True,
        True,
    ]


def test_a_mountain_is_highest_in_the_middle_and_flat_at_its_foot():
    terrain = Terrain(
        Space((20, 20), "walls"), 0.5, mountains=[{"at": [10.0, 10.0], "radius": 5.0, "height": 8.0}]
    )

    def h(x, y):
        return height_at(terrain.maps, F(x), F(y), False)

    assert h(10, 10) == pytest.approx(8, rel=0.05)
    assert h(12.5, 10) == pytest.approx(4, rel=0.1)  # half way, half the height
    assert h(15.5, 10) == 0
    profile = [h(10 + d, 10) for d in np.linspace(0, 5, 20)]
    assert all(a >= b for a, b in zip(profile, profile[1:], strict=False))


@pytest.mark.parametrize("torus", [True, False])
def test_heights_are_linear_between_the_centres_of_cells(torus):
    rng = np.random.default_rng(5)
    terrain = Terrain(Space((6, 4), "torus" if torus else "walls"), 1.0)
    terrain.height[...] = rng.random((4, 6))
    for x, y in rng.random((100, 2)) * [6, 4]:
        i, j = int(np.floor(x - 0.5)), int(np.floor(y - 0.5))
        fx, fy = x - 0.5 - i, y - 0.5 - j

        def corner(i, j):
            return terrain.height[(j % 4, i % 6) if torus else (np.clip(j, 0, 3), np.clip(i, 0, 5))]

        expected = (1 - fy) * ((1 - fx) * corner(i, j) + fx * corner(i + 1, j)) + fy * (
            (1 - fx) * corner(i, j + 1) + fx * corner(i + 1, j + 1)
        )
        assert height_at(terrain.maps, F(x), F(y), torus) == pytest.approx(expected, abs=1e-5)


def test_hills_have_the_size_asked_for_are_the_same_for_the_same_seed_and_close_around_the_torus():
    def hills(seed, amplitude=3.0):
        return Terrain(
            Space((60, 60)), 1.0, hills={"seed": seed, "amplitude": amplitude, "scale": 15.0}
        ).height

    one = hills(1)
    assert (one == hills(1)).all()
    assert (one != hills(2)).any()
    assert np.allclose(hills(1, 6.0), 2 * one, atol=1e-4)
    assert 0.5 * 3 < one.std() < 2 * 3
    steps = np.abs(np.diff(one, axis=1)).max()
    assert np.abs(one[:, 0] - one[:, -1]).max() <= 1.1 * steps  # no cliff at the seam


@pytest.mark.parametrize(
    ("corners", "cells"),
    [
        ([[0.5, 0.5], [3.5, 0.5]], [(0, 0), (1, 0), (2, 0), (3, 0)]),
        ([[0.5, 0.5], [2.5, 1.3]], [(0, 0), (1, 0), (1, 1), (2, 1)]),  # y is 1 at x = 1.75
        # through corners: by way of the cell beside them
        ([[0.5, 0.5], [2.5, 2.5]], [(0, 0), (1, 0), (1, 1), (2, 1), (2, 2)]),
        ([[2.5, 1.5], [0.5, 1.5], [0.5, 0.2]], [(2, 1), (1, 1), (0, 1), (0, 0)]),
        ([[0.5, 0.5], [-1.5, 0.5]], [(0, 0), (-1, 0), (-2, 0)]),
    ],
)
def test_the_cells_of_a_line_are_those_it_passes_each_beside_the_next(corners, cells):
    assert [tuple(c) for c in cells_along(np.array(corners)).tolist()] == cells


def test_no_line_has_a_gap_at_a_corner():
    generator = np.random.Generator(np.random.Philox(1))
    for corners in generator.uniform(-5, 30, (200, 4, 2)):
        steps = np.abs(np.diff(cells_along(corners), axis=0)).sum(axis=1)
        assert (steps == 1).all()


def test_ground_with_fences_is_saved_and_brought_back():
    space = Space((20.0, 10.0), "torus")
    a, b = (Terrain(space, 1.0, lakes=[{"at": [5.0, 5.0], "radius": 2.0}]) for _ in range(2))
    a.fence(np.array([[0.5, 5.5], [19.5, 5.5]]))
    a.fence(np.array([[15.5, 0.5], [15.5, 9.5], [18.0, 9.5]]))
    assert np.unique(a.ground[5], return_counts=True)[1].tolist() == [4, 16]  # of 20 cells 4 are water
    b.load(a.state())
    assert (b.ground == a.ground).all()
    for terrain in (a, b):
        terrain.unfence(np.array([[0.5, 5.5], [19.5, 5.5]]))
        assert terrain.ground[5, 15] == FENCE  # the other one
        assert terrain.ground[5, 12] == 0
    with pytest.raises(ValueError, match="there is no fence along"):
        b.unfence(np.array([[0.5, 5.5], [19.5, 5.5]]))
    with pytest.raises(ValueError, match="cells"):
        Terrain(space, 2.0).load(a.state())
