import numpy as np
import pytest

from ecs_eco.analysis.migration import (
    Cosinor,
    approaches,
    chemotaxis_index,
    cosinor,
    event_average,
    follow,
    mean_cosinor,
    p_common_phase,
    p_of_days,
    v_test,
)  # fmt: skip
from ecs_eco.testing import arrange


def test_a_cosine_is_found_again():
    t = np.arange(0, 600, 7)
    fit = cosinor(t, 12 + 5 * np.cos(2 * np.pi * (t - 40) / 200), 200)
    assert (fit.mesor, fit.amplitude, fit.acrophase) == pytest.approx((12, 5, 2 * np.pi * 40 / 200))


def test_four_values_by_hand():
    fit = cosinor([0, 1, 2, 3], [3, 1, 1, 3], 4)  # cosine: (3 − 1)/2 = 1, sine: (1 − 3)/2 = −1
    assert (fit.mesor, fit.amplitude, fit.acrophase) == pytest.approx((2, np.sqrt(2), 7 * np.pi / 4))


def test_runs_of_opposite_phases_cancel():
    mean = mean_cosinor([Cosinor(1, 2, 0.0), Cosinor(3, 2, np.pi)])
    assert (mean.mesor, mean.amplitude) == pytest.approx((2, 0), abs=1e-12)
    assert mean_cosinor([Cosinor(0, 3, 0.0), Cosinor(0, 4, np.pi / 2)]).amplitude == pytest.approx(2.5)


def test_a_common_phase_is_told_from_random_ones():
    assert p_common_phase([Cosinor(0, 1, 0.1 * i) for i in range(6)]) < 0.001
    rng = np.random.default_rng(3)
    p = [p_common_phase([Cosinor(0, 1, a) for a in rng.uniform(0, 2 * np.pi, 5)], n=199, seed=s) for s in range(200)]
    assert 0.02 <= np.mean(np.array(p) <= 0.05) <= 0.1  # as often as it says


def test_days_alike_are_told_from_days_apart():
    hours = np.arange(24)
    alike = np.stack([np.cos(2 * np.pi * hours / 24)] * 8)
    assert p_of_days(alike) < 0.001
    rng = np.random.default_rng(4)
    apart = [np.stack([np.cos(2 * np.pi * (hours - rng.integers(24)) / 24) for _ in range(8)]) for _ in range(200)]
    assert 0.02 <= np.mean([p_of_days(days, n=199, seed=i) <= 0.05 for i, days in enumerate(apart)]) <= 0.1


def test_a_drift_makes_no_days():
    rng, low = np.random.default_rng(5), 0
    for i in range(60):
        noise = np.zeros(20 * 48)
        for t in range(1, noise.size):
            noise[t] = 0.98 * noise[t - 1] + rng.normal(0, 0.2)
        low += p_of_days((noise + np.linspace(0, 15, noise.size)).reshape(20, 48), n=199, seed=i) <= 0.01
    assert low <= 4  # 1 in 100 by chance


def test_windows_around_events_are_averaged_and_what_is_missing_left_out():
    series = np.array([[1.0, 10.0], [2.0, np.nan], [3.0, 30.0], [4.0, 40.0]])
    mean = event_average(series, np.array([[1, 0], [3, 1]]), before=1, after=1)
    assert mean.tolist() == [(1 + 30) / 2, (2 + 40) / 2, 3.0]
    assert np.isnan(event_average(series, np.array([[3, 0]]), 0, 1)[1])


def test_an_approach_begins_where_it_has_been_far_for_a_while():
    far, near = 9.0, 1.0
    distance = np.array([[far, far, near, near, far, near, far, far, far, near]]).T
    assert approaches(distance, within=2.0, rest=2).tolist() == [[2, 0], [9, 0]]
    newborn = np.array([[np.nan, np.nan, near, near]]).T
    assert approaches(newborn, within=2.0, rest=2).size == 0


def test_the_v_test_by_hand():
    u, p = v_test(np.array([1.0, 0.5, 0.5, 1.0, -1.0, 1.0, 0.0, 1.0]))  # sum 4, times sqrt(2/8)
    assert (u, p) == pytest.approx((2.0, 0.02275), abs=1e-5)
    assert v_test(np.array([-1.0, 1.0]))[1] == pytest.approx(0.5)


def test_the_index_of_those_who_leave():
    assert chemotaxis_index(30, 10) == 0.5
    assert np.isnan(chemotaxis_index(0, 0))


def test_tracks_tell_depth_speed_and_the_way_from_the_predator(meadow):
    wolf = {"count": 1, "body": {"radius": 0.1}}
    sea = {"size": [20.0, 20.0, 10.0]}
    world = meadow(world={"space": sea, "species": {"wolf": wolf}}, count=2, reflex={"formulas": {"walk": "1"}}, lethal=[])
    arrange(world, "deer", x=[1, 5], y=5, z=[4, 9], heading=[0, np.pi / 2])
    arrange(world, "wolf", x=19, y=5, z=4)  # 2 m behind the first, across the edge
    tracks = follow(world, 2, "deer", "wolf", within=5.0)
    assert tracks.depth.tolist() == [[6, 1], [6, 1]]
    assert tracks.mean_depth.tolist() == [3.5, 3.5]
    assert tracks.speed == pytest.approx(np.ones((2, 2)), abs=1e-5)
    assert tracks.distance[:, 0] == pytest.approx([2, 3])
    assert tracks.distance[0, 1] == np.inf
    assert tracks.away[:, 0] == pytest.approx([1, 1], abs=1e-5)
    assert np.isnan(tracks.away[0, 1])
    assert tracks.aside[:, 0] == pytest.approx([0, 0], abs=1e-5)
    assert tracks.light.tolist() == [1, 1]


def test_the_side_of_away_is_on_the_left(meadow):
    wolf = {"count": 1, "body": {"radius": 0.1}}
    sea = {"size": [20.0, 20.0, 10.0]}
    world = meadow(world={"space": sea, "species": {"wolf": wolf}}, count=4, reflex={"formulas": {"walk": "1"}}, lethal=[])
    arrange(world, "deer", x=[5, 7, 5, 3], y=[7, 5, 3, 5], z=4, heading=np.pi / 2)  # all swim north, around a wolf
    arrange(world, "wolf", x=5, y=5, z=4)
    tracks = follow(world, 1, "deer", "wolf")
    assert tracks.away[0] == pytest.approx([1, 0, -1, 0], abs=1e-5)
    assert tracks.aside[0] == pytest.approx([0, 1, 0, -1], abs=1e-5)
