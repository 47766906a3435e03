import numpy as np
import pytest

from ecs_eco.learning import choose, choose_best


def _twin(logits, offsets, uniforms):
    """The obvious way, in float64."""
    choices, log_probabilities = [], []
    for row, chances in zip(logits.astype(float), uniforms, strict=True):
        picks, total = [], 0.0
        for low, high, chance in zip(offsets, offsets[1:], chances, strict=False):
            p = np.exp(row[low:high]) / np.exp(row[low:high]).sum()
            picks.append(min(int(np.searchsorted(np.cumsum(p), chance, side="right")), high - low - 1))
            total += np.log(p[picks[-1]])
        choices.append(picks)
        log_probabilities.append(total)
    return np.array(choices), np.array(log_probabilities)


@pytest.mark.parametrize("n", [1, 127, 128, 129, 1000])
@pytest.mark.parametrize("dtype", [np.int8, np.int16])
def test_choices_and_probabilities_agree_with_the_definition(n, dtype):
    rng = np.random.default_rng(n)
    offsets = np.array([0, 3, 4, 9])
    logits, uniforms = rng.normal(0, 2, (n, 9)).astype(np.float32), rng.random((n, 3), dtype=np.float32)
    choice, log_probability = np.empty((n, 3), dtype), np.empty(n, np.float32)
    choose(logits, offsets, uniforms, choice, log_probability)
    right, right_log = _twin(logits, offsets, uniforms)
    assert (choice != right).any(axis=1).mean() < 1e-3  # but for a uniform within rounding of an edge
    same = (choice == right).all(axis=1)
    np.testing.assert_allclose(log_probability[same], right_log[same], rtol=1e-5, atol=2e-6)


def test_choices_come_as_often_as_their_probability():
    n, logits = 100_000, np.log(np.array([0.1, 0.2, 0.7], np.float32))
    choice, log_probability = np.empty((n, 1), np.int8), np.empty(n, np.float32)
    uniforms = np.random.default_rng(0).random((n, 1), dtype=np.float32)
    choose(np.tile(logits, (n, 1)), np.array([0, 3]), uniforms, choice, log_probability)
    np.testing.assert_allclose(np.bincount(choice[:, 0]) / n, [0.1, 0.2, 0.7], atol=0.005)


def test_extreme_uniforms_and_logits_stay_within_the_group():
    logits = np.array([[0, 0, 0], [-500, 500, -500], [0, 0, 0]], np.float32)
    uniforms = np.array([[0.0], [0.5], [np.nextafter(np.float32(1), np.float32(0))]], np.float32)
    choice, log_probability = np.empty((3, 1), np.int8), np.empty(3, np.float32)
    choose(logits, np.array([0, 3]), uniforms, choice, log_probability)
    assert choice[:, 0].tolist() == [0, 1, 2]
    np.testing.assert_allclose(log_probability, [-np.log(3), 0, -np.log(3)], atol=1e-6)


def test_the_best_choice_is_the_first_of_the_likeliest():
    choice = np.empty((2, 2), np.int8)
    choose_best(np.array([[0, 2, 1, 5, 5], [3, 1, 2, 0, 9]], np.float32), np.array([0, 3, 5]), choice)
    assert choice.tolist() == [[1, 0], [0, 1]]
