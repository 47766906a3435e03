import numpy as np
import pytest

from ecs_eco.space import Space, geometry
from ecs_eco.space.geometry import back_into, into, wrapped

F = np.float32


@pytest.mark.parametrize(
    ("v", "there"),
    [(3.0, 3.0), (10.0, 0.0), (-0.5, 9.5), (25.0, 5.0), (-20.0, 0.0), (-1e-9, 0.0), (0.0, 0.0)],
)
def test_around_a_torus(v, there):
    assert into(F(v), F(10), True) == F(there)
    assert back_into(np.array([v], F), F(10), True)[0] in (F(there), np.nextafter(F(10), F(0)))


@pytest.mark.parametrize(("v", "there"), [(3.0, 3.0), (-0.5, 0.0), (10.0, 9.999999), (1e9, 9.999999)])
def test_to_a_wall(v, there):
    assert into(F(v), F(10), False) == F(there)
    assert back_into(np.array([v], F), F(10), False)[0] == F(there)


def test_nothing_lands_on_the_far_edge_whatever_the_length():
    rng = np.random.default_rng(1)
    for length in rng.uniform(0.1, 1000, 300).astype(F):
        for v in (rng.uniform(-3, 3, 20) * length).astype(F):
            for torus in (True, False):
                assert 0 <= into(v, length, torus) < length
                assert 0 <= back_into(np.array([v]), length, torus)[0] < length


def test_wrapped_is_the_shortest_way_on_a_ring():
    for d, shortest in ((3, 3), (7, -3), (-7, 3), (12, 2), (0, 0)):
        assert wrapped(F(d), F(10)) == F(shortest)
    assert abs(wrapped(F(5), F(10))) == 5


def test_whole_cells_cover_the_space_and_are_not_smaller_than_asked_for():
    space = Space((10, 7), cell=1.5)
    assert space.shape == (6, 4, 1)
    assert space.n_cells == 24
    assert np.allclose(space.inverse, [6 / 10, 4 / 7, 0])
    assert Space((10, 7, 5), cell=2.0).shape == (5, 3, 2)
    assert Space((10, 7), cell=100.0).shape == (1, 1, 1)
    assert Space((10_000, 10_000), cell=0.1).n_cells <= 4_000_000


def test_reach_counts_cells_to_the_side():
    space = Space((10, 10), cell=2.0)
    assert [space.reach(r) for r in (0.5, 2.0, 2.1, 4.0, 9.0)] == [1, 1, 2, 2, 5]


def test_extent_and_edges():
    torus, box = Space((30, 40)), Space((30, 40, 12), "walls")
    assert (torus.volume, box.volume) == (False, True)
    assert torus.wrap == (True, True, False)
    assert torus.lengths.tolist() == [30, 40, 0]


def test_a_space_that_cannot_be_is_refused():
    for size in ((1,), (1, 2, 3, 4), (1, -2), (0, 1), (float("nan"), 1)):
        with pytest.raises(ValueError, match="must be two or three positive numbers"):
            Space(size)


ODD = [
    np.nan,
    np.inf,
    -np.inf,
    -0.0,
    0.0,
    1e-45,
    -1e-45,
    1e38,
    -1e38,
    3.4e38,
    -3.4e38,
    1e30,
    9.3e18,
    2147483648.0,
    -500.0,
    -1.0,
    4.0,
    4.5,
    1e9,
]


@pytest.mark.parametrize("v", ODD)
def test_every_number_has_a_cell(v):
    v = np.float32(v)
    assert geometry.cell_of(v, 5) == (0 if np.isnan(v) else int(np.clip(v, 0, 4)))
    assert geometry.floor_between(v, -1, 5) == (-1 if np.isnan(v) else np.floor(np.clip(v, -1, 5)))
    assert geometry.cells_of(np.array([v]), 1.0, 5).tolist() == [geometry.cell_of(v, 5)]
    inverse, lengths = np.array([2.0, 1.0], np.float32), np.array([10.0, 20.0, 0.0], np.float32)
    assert geometry.half_cells(v, inverse, lengths) == (
        0 if np.isnan(v) else int(np.clip(np.ceil(np.float64(v) * 4), 0, 120))
    )


@pytest.mark.parametrize("v", ODD)
@pytest.mark.parametrize("torus", [True, False])
def test_every_number_comes_back_into_the_space(v, torus):
    length = np.float32(60)
    assert 0 <= geometry.into(np.float32(v), length, torus) < length


def test_a_look_spans_no_more_cells_than_there_are():
    space = Space((60.0, 40.0), cell=4.0)
    spans = [space.reach(r) for r in (np.nan, -1.0, 0.0, 3.9, 8.1, 1e30, np.inf)]
    assert spans == [0, 0, 0, 1, 3, 15, 15]
