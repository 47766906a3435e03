import inspect
from typing import Any

import numpy as np
import pytest

from ecs_eco.compiled.vectors import LANES
from ecs_eco.learning.tiles import ROWS, column_sums, product, round_up


def product_in_tiles_of(wide):
    """`product` for processors with (AVX-512) and without registers for two vectors; never from the cache."""
    names: dict[str, Any] = {**product.py_func.__globals__, "WIDE": wide}
    exec(inspect.getsource(product.py_func), names)
    return names["product"]


def room_of(*parts, room_left):
    """Return parts, and zeros, in one flat array; and where each begins, the zeros too."""
    ends = np.cumsum([part.size for part in parts])
    return np.concatenate([*(part.ravel() for part in parts), np.zeros(room_left, np.float32)]), [0, *ends]


def made(rng, *shape):
    return rng.normal(size=shape).astype(np.float32)


@pytest.mark.parametrize("transposed", [False, True])
@pytest.mark.parametrize(("rows", "n", "wide"), [(24, 32, 32), (4, 7, 16), (8, 1, 48)])
def test_products_are_those_of_numpy(rows, n, wide, transposed):
    rng = np.random.default_rng(n)
    x, matrix, bias = made(rng, rows, n), made(rng, n, wide), made(rng, wide)
    room, (_, at_matrix, at_bias, out) = room_of(
        x.T if transposed else x, matrix, bias, room_left=rows * wide
    )
    step_row, step = (1, rows) if transposed else (n, 1)
    product(room, 0, step_row, step, rows, at_matrix, wide, n, at_bias, 0, out, wide, wide)
    np.testing.assert_allclose(
        room[out:].reshape(rows, wide), x @ matrix.astype(float) + bias, rtol=2e-5, atol=2e-5
    )


@pytest.mark.parametrize("wide", [False, True])
@pytest.mark.parametrize("columns", [3, 20, 33, 64, 70])
def test_rows_of_any_length_lie_without_gaps_in_tiles_of_both_widths(wide, columns):
    rng, rows, n = np.random.default_rng(columns), 8, 5
    padded = round_up(columns, LANES)
    x, bias = made(rng, rows, n), np.zeros(padded, np.float32)
    matrix = np.zeros((n, padded), np.float32)
    matrix[:, :columns] = made(rng, n, columns)
    space, (_, at_matrix, at_bias, out) = room_of(x, matrix, bias, room_left=rows * columns + 2 * LANES)
    product_in_tiles_of(wide)(space, 0, n, 1, rows, at_matrix, padded, n, at_bias, 0, out, columns, columns)
    np.testing.assert_allclose(
        space[out : out + rows * columns].reshape(rows, columns),
        x @ matrix[:, :columns].astype(float),
        rtol=2e-5,
        atol=2e-5,
    )


def test_a_bias_may_be_of_rows():
    rng = np.random.default_rng(2)
    x, matrix, bias = made(rng, 8, 3), made(rng, 3, 48), made(rng, 8)
    room, (_, at_matrix, at_bias, out) = room_of(x, matrix, np.repeat(bias, LANES), room_left=8 * 48)
    product(room, 0, 3, 1, 8, at_matrix, 48, 3, at_bias, LANES, out, 48, 48)
    np.testing.assert_allclose(room[out:].reshape(8, 48), x @ matrix + bias[:, None], rtol=2e-5, atol=2e-5)


def test_a_number_does_not_depend_on_the_others():
    rng = np.random.default_rng(5)
    x, matrix, bias = made(rng, 2 * ROWS, 7), made(rng, 7, 2 * LANES), made(rng, 2 * LANES)
    among, (_, at_matrix, at_bias, out) = room_of(x, matrix, bias, room_left=4 * ROWS * LANES)
    product(among, 0, 7, 1, 2 * ROWS, at_matrix, 2 * LANES, 7, at_bias, 0, out, 2 * LANES, 2 * LANES)
    expected = among[out:].reshape(2 * ROWS, -1)[ROWS:, LANES:]
    alone, (_, at_matrix, at_bias, out) = room_of(
        x[ROWS:], matrix[:, LANES:], bias[LANES:], room_left=ROWS * LANES
    )
    product(alone, 0, 7, 1, ROWS, at_matrix, LANES, 7, at_bias, 0, out, LANES, LANES)
    np.testing.assert_array_equal(alone[out:].reshape(ROWS, LANES), expected)


@pytest.mark.parametrize("rows", [4, 12, 32])
def test_sums_of_columns(rows):
    matrix = made(np.random.default_rng(rows), rows, 32)
    room, (at, out) = room_of(matrix, room_left=32)
    column_sums(room, at, rows, 32, out)
    np.testing.assert_allclose(room[out:], matrix.sum(axis=0, dtype=float), rtol=1e-5, atol=1e-5)


def test_multiples():
    assert [round_up(n, 4) for n in (1, 4, 5)] == [4, 4, 8]
