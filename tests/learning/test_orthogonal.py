"""Random matrices of both modes are orthogonal, the numbers of the portable mode normal."""

from types import SimpleNamespace

import numpy as np
import pytest

from ecs_eco.learning import brain
from ecs_eco.learning.brain import normals, orthogonal


@pytest.mark.parametrize("portable", [False, True])
@pytest.mark.parametrize("shape", [(3, 8), (8, 3), (6, 6)])
def test_an_orthogonal_matrix_is_orthogonal_and_the_same_for_the_same_numbers(shape, portable, monkeypatch):
    monkeypatch.setattr(brain, "portable", SimpleNamespace(on=lambda: portable))
    q = orthogonal(np.random.Generator(np.random.Philox(1)), *shape)
    assert q.shape == shape
    least = q @ q.T if shape[0] <= shape[1] else q.T @ q
    assert np.allclose(least, np.eye(min(shape)))
    assert np.array_equal(q, orthogonal(np.random.Generator(np.random.Philox(1)), *shape))


def test_normal_numbers_are_normal():
    numbers = normals(np.random.Generator(np.random.Philox(2)), (200, 200))
    assert abs(numbers.mean()) < 0.02
    assert abs(numbers.std() - 1) < 0.02
