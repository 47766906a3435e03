import math

import numpy as np
import pytest
import torch
from scipy import stats

from ecs_eco.learning import CONTINUOUS, Brain
from ecs_eco.learning.continuous import draw_numbers, in_units, laid_out


def _drawn(mean, log_deviation, n=100_000):
    outputs = np.tile(np.array([mean, log_deviation], np.float32), (n, 1))
    numbers, log_probability = np.empty((n, 1), np.float32), np.zeros(n, np.float32)
    uniforms = np.random.default_rng(5).random((n, 2), dtype=np.float32)
    draw_numbers(outputs, uniforms, numbers, log_probability)
    return numbers[:, 0], log_probability


@pytest.mark.parametrize(("mean", "log_deviation"), [(0.0, 0.0), (-0.7, -2.0), (3.0, 1.0)])
def test_numbers_are_drawn_from_the_normal_distribution_that_the_outputs_name(mean, log_deviation):
    numbers, log_probability = _drawn(mean, log_deviation)
    normal = stats.norm(mean, math.exp(log_deviation))
    assert stats.kstest(numbers, normal.cdf).pvalue > 1e-3
    np.testing.assert_allclose(log_probability, normal.logpdf(numbers), atol=2e-5, rtol=1e-5)


@pytest.mark.parametrize(("given", "held"), [(-40.0, -5.0), (9.0, 2.0)])
def test_the_deviation_is_held_between_two_limits(given, held):
    numbers, _ = _drawn(0.0, given)
    assert numbers.std() == pytest.approx(math.exp(held), rel=0.02)


def test_the_edges_of_the_uniforms_give_finite_numbers():
    uniforms = np.array([[0, 0], [0, 0.5], [1 - 2**-24, 0.25], [1 - 2**-24, 0]], np.float32)
    numbers, log_probability = np.empty((4, 1), np.float32), np.zeros(4, np.float32)
    draw_numbers(np.zeros((4, 2), np.float32), uniforms, numbers, log_probability)
    assert numbers[:2].tolist() == [[0], [0]]
    assert numbers[3, 0] == pytest.approx(math.sqrt(48 * math.log(2)), rel=1e-5)
    assert np.isfinite(log_probability).all()


def test_minus_one_and_one_are_the_limits_of_the_range_and_what_is_beyond_is_the_limit():
    low, high = np.array([-2.0, 0.0], np.float32), np.array([2.0, 3.0], np.float32)
    assert in_units(np.array([[-1, -9], [0, 0.5], [7, 1]], np.float32), low, high).tolist() == [
        [-2, 0],
        [0, 2.25],
        [2, 3],
    ]


def test_a_head_is_a_mean_and_a_spread_after_all_choices():
    offsets, numbers = laid_out((3, 2, CONTINUOUS, CONTINUOUS))
    assert offsets.tolist() == [0, 3, 5]
    assert numbers == 2
    brain = Brain(4, (3, CONTINUOUS))
    assert (brain.n_logits, brain.n_numbers, brain.offsets.tolist()) == (5, 1, [0, 3])
    assert torch.nn.Linear(2, sum(brain.groups)).out_features == 5
    with pytest.raises(ValueError, match=r"groups = \(CONTINUOUS, 3\): continuous ones must come last"):
        laid_out((CONTINUOUS, 3))
