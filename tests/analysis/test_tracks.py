"""Approaches, windows around them and directions, by hand."""

import numpy as np
import pytest

from ecs_eco.analysis.tracks import approaches, event_average, v_test


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
