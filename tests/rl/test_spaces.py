"""Spaces have the bounds that senses and actions have."""

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="ecs-eco[rl] is not installed")

from gymnasium import spaces as gym

from ecs_eco.rl.spaces import action_space, flattened, matrix, stacked, width

NUMBERS = np.array([0.5], np.float32), np.array([2.0], np.float32)


def test_one_group_is_discrete_several_are_multidiscrete_numbers_a_box_and_both_a_dict():
    zero, two = np.zeros(2, np.float32), np.full(2, 2, np.float32)
    assert action_space({"turn": ("a", "b", "c")}, zero[:1], two[:1]) == gym.Discrete(3)
    assert action_space({"a": ("x", "y", "z"), "b": ("x", "y")}, zero, two) == gym.MultiDiscrete([3, 2])
    assert action_space({"speed": ()}, *NUMBERS) == gym.Box(*NUMBERS, dtype=np.float32)
    both = action_space(
        {"turn": ("a", "b", "c"), "speed": ()},
        *(np.concatenate([end[:1], number]) for end, number in zip((zero, two), NUMBERS, strict=True)),
    )
    assert both["turn"] == gym.Discrete(3)
    assert (both["speed"].low, both["speed"].high) == (0.5, 2.0)


@pytest.mark.parametrize(
    "space",
    [
        gym.Discrete(3),
        gym.MultiDiscrete([3, 2]),
        gym.Box(*NUMBERS, dtype=np.float32),
        action_space({"turn": ("a", "b", "c"), "speed": ()}, np.array([0, 0.5]), np.array([2, 2.0])),
    ],
)
def test_sampled_actions_become_a_row_each(space):
    actions = [space.sample() for _ in range(4)]
    rows = matrix(space, stacked(space, actions), 4)
    assert rows.shape == (4, width(space))
    assert matrix(space, stacked(space, []), 0).shape == (0, width(space))
    first = actions[1]["turn"] if isinstance(space, gym.Dict) else np.ravel(actions[1])[0]
    assert rows[1, 0] == first


def test_options_and_numbers_are_flattened_to_a_box_that_divides_their_ranges_evenly():
    both = action_space({"turn": ("a", "b", "c"), "speed": ()}, np.array([0, 0.5]), np.array([2, 2.0]))
    assert flattened(both) == gym.Box(-1, 1, (2,), np.float32)
    assert flattened(gym.Discrete(3)) == gym.Discrete(3)
    chosen = [[-1, -1], [-0.34, 0], [-0.33, 0.5], [0.33, 1], [0.34, 7], [1, -7]]
    assert matrix(both, np.array(chosen), 6).tolist() == [
        [0, 0.5],
        [0, 1.25],
        [1, 1.625],
        [1, 2],
        [2, 2],
        [2, 0.5],
    ]
    assert matrix(both, stacked(both, []), 0).shape == matrix(both, np.zeros((0, 2)), 0).shape == (0, 2)
