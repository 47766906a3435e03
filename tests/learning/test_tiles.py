import numpy as np
import pytest

from ecs_eco.learning.tiles import LANES, add_product


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(("n_in", "n_out", "blocks"), [(24, 32, 1), (7, 9, 2), (1, 1, 1), (2, 5, 3)])
def test_products_are_those_of_numpy(n_in, n_out, blocks, turned):
    rng = np.random.default_rng(n_in)
    matrix = rng.normal(size=(n_out, n_in) if turned else (n_in, n_out)).astype(np.float32)
    matrix = matrix.T if turned else matrix
    below = rng.normal(size=(n_in, blocks * LANES)).astype(np.float32)
    above = rng.normal(size=(n_out, blocks * LANES)).astype(np.float32)
    expected = above + matrix.T.astype(float) @ below
    add_product(matrix, below, above)
    np.testing.assert_allclose(above, expected, rtol=2e-5, atol=2e-5)


def test_a_column_does_not_depend_on_the_others():
    rng = np.random.default_rng(5)
    matrix = rng.normal(size=(7, 9)).astype(np.float32)
    below = rng.normal(size=(7, 2 * LANES)).astype(np.float32)
    alone, among = np.zeros((9, LANES), np.float32), np.zeros((9, 2 * LANES), np.float32)
    add_product(matrix, np.ascontiguousarray(below[:, LANES:]), alone)
    add_product(matrix, below, among)
    np.testing.assert_array_equal(alone, among[:, LANES:])
