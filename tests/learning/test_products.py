"""Products of the portable mode are those of numpy, to rounding, whatever the shapes."""

import numpy as np
import pytest
import torch

from ecs_eco.learning import products


@pytest.fixture
def numbers():
    generator = np.random.Generator(np.random.Philox(5))
    return lambda *shape: torch.from_numpy(generator.normal(size=shape).astype(np.float32))


@pytest.mark.parametrize(("n", "a", "b"), [(1, 1, 1), (7, 5, 3), (64, 24, 64), (130, 64, 9)])
def test_a_layers_products_there_and_back_again(numbers, n, a, b):
    x, w, bias, d = numbers(n, a), numbers(a, b), numbers(b), numbers(b, n)
    for ours, theirs, args in ((products.addmm, torch.addmm, (bias, x, w)),
                               (products.addmm, torch.addmm, (bias[:, None], w.t().contiguous(), x.t())),
                               (products.mm, torch.mm, (d, x)),
                               (products.mm, torch.mm, (d.t(), w.t().contiguous())),
                               (products.mm, torch.mm, (x.t(), d.t().contiguous()))):
        expected = theirs(*args)
        out = torch.full(expected.shape, torch.nan)
        ours(*args, out=out)
        assert torch.allclose(out, expected, atol=1e-4)
    out = torch.full((b, 1), torch.nan)
    products.row_sums(d, out=out)
    assert torch.allclose(out, d.sum(1, keepdim=True), atol=1e-4)


@pytest.mark.parametrize("shape", [(3, 8), (8, 3), (6, 6)])
def test_an_orthogonal_matrix_is_orthogonal_and_the_same_for_the_same_numbers(shape):
    q = products.orthogonal(np.random.Generator(np.random.Philox(1)), *shape)
    assert q.shape == shape
    least = q @ q.T if shape[0] <= shape[1] else q.T @ q
    assert np.allclose(least, np.eye(min(shape)))
    assert np.array_equal(q, products.orthogonal(np.random.Generator(np.random.Philox(1)), *shape))


def test_normal_numbers_are_normal():
    numbers = products.normals(np.random.Generator(np.random.Philox(2)), (200, 200))
    assert abs(numbers.mean()) < 0.02
    assert abs(numbers.std() - 1) < 0.02
