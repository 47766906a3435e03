"""Water fills hollows to their lowest outlet and runs to the rim."""

import numpy as np
import pytest

from ecs_eco.space.drainage import drained

NOWHERE = np.zeros((5, 6), np.bool_)


def _plain(height, sea):
    """Raise every cell until none is above all that it can drain to: Planchon & Darboux 2002."""
    level = np.full(height.shape, np.inf)
    rim = sea.copy()
    rim[[0, -1]] = rim[:, [0, -1]] = True
    level[rim] = height[rim]
    while True:
        around = np.pad(level, 1, constant_values=np.inf)
        lowest = np.min(
            [
                around[1 + j : 1 + j + height.shape[0], 1 + i : 1 + i + height.shape[1]]
                for j in (-1, 0, 1)
                for i in (-1, 0, 1)
            ],
            axis=0,
        )
        new = np.where(rim, level, np.maximum(height, lowest))
        if np.array_equal(new, level):
            return level
        level = new


def test_a_hollow_is_filled_to_its_lowest_rim():
    height = np.full((5, 6), 9.0, np.float32)
    height[2, 1:5] = [3, 2, 1, 4]
    height[2, 5] = 6  # its outlet
    level, area = drained(height, NOWHERE)
    assert level[2, 1:5].tolist() == [6, 6, 6, 6]
    assert (level[[0, 4]] == 9).all()
    assert area[2, 5] == 13  # all 12 within, and itself
    assert area.sum() > 30


def test_water_leaves_into_the_sea():
    height = np.full((5, 6), 9.0, np.float32)
    height[2, 1:5] = [3, 2, 1, 4]
    sea = height == 1
    level, area = drained(height, sea)
    assert level[2, 1:5].tolist() == [3, 2, 1, 4]
    assert area[2, 3] >= 4


@pytest.mark.parametrize("seed", range(4))
def test_levels_are_those_of_the_plain_way_and_all_water_leaves(seed):
    rng = np.random.default_rng(seed)
    height = rng.integers(0, 9, (23, 31)).astype(np.float32)
    sea = height == 0 if seed % 2 else np.zeros(height.shape, np.bool_)
    level, area = drained(height, sea)
    assert np.array_equal(level, _plain(height.astype(float), sea))
    outlets = sea.copy()
    outlets[[0, -1]] = outlets[:, [0, -1]] = True
    assert area[outlets].sum() == height.size
    assert (area >= 1).all()
