import numpy as np
import pytest

from ecs_eco import Table, World, component, f32, njit
from ecs_eco.compiled.vectors import LANES, load, store
from ecs_eco.engine.blocks import BLOCK, SPARE, Blocked, apart, block_of, flat_block_of, prefetch_row
from ecs_eco.testing import check_component


@component
class Brain:
    """Many numbers."""

    weights: f32["weights", 2].heavy = 0.5


def test_a_blocked_column_reads_and_writes_as_an_array():
    rng = np.random.default_rng(1)
    column, plain = Blocked((3,), np.float32).grow(700), np.zeros((700, 3), np.float32)
    for rows in (
        np.array([699, 0, 255, 256, 511, 512]),
        np.arange(700) % 7 == 0,
        slice(250, 260),
        np.array([], int),
    ):
        n = plain[rows].shape[0]
        value = rng.random((n, 3), np.float32)
        column[rows] = value
        plain[rows] = value
        assert np.array_equal(column[rows], plain[rows])
    column[3], plain[3] = 9, 9
    column[np.array([5, 600])], plain[[5, 600]] = [1, 2, 3], [1, 2, 3]
    assert column[3].tolist() == [9, 9, 9]
    assert np.array_equal(np.asarray(column), plain)
    assert (column.shape, len(column), column.nbytes) == ((700, 3), 700, 3 * BLOCK * 3 * 4)


def test_a_row_beyond_the_capacity_is_refused():
    column = Blocked((), np.float32).grow(300)
    for rows in (300, -1, np.array([299, 300])):
        with pytest.raises(IndexError, match="of a column of 300"):
            column[rows]


def test_growth_moves_no_block():
    table = Table("ant", (Brain,), capacity=4, dims={"weights": 3})
    table.occupy(200, 1, 0, {})
    column = table[Brain].weights
    first = column.blocks[0]
    table.occupy(400, 201, 0, {})
    assert table[Brain].weights is column
    assert column.blocks[0] is first
    assert column.shape == (table.capacity, 3, 2)
    assert (column[599] == 0.5).all()


@njit
def add_to_rows(rows, column, number):
    for row in rows:
        block_of(row, column)[row % BLOCK] += number


def test_a_kernel_reaches_rows_by_the_addresses_of_blocks():
    column = Blocked((2,), np.float32).grow(10)
    column[9] = [1, 2]
    add_to_rows(np.array([9]), column.grow(3 * BLOCK).by_address(), 5)
    add_to_rows(np.array([BLOCK, 3 * BLOCK - 1]), column.by_address(), 7)
    assert column[np.array([9, 8, BLOCK, 3 * BLOCK - 1])].tolist() == [[6, 7], [0, 0], [7, 7], [7, 7]]


@njit
def first_of(row, other, column):
    """The first number of one row, by way of another."""
    prefetch_row(other, column)
    return load(flat_block_of(row, column), row % BLOCK * 3 + apart(row, other, column))


@njit
def write_first(row, other, column, out):
    store(out, 0, first_of(row, other, column))


def test_a_row_is_reached_from_another_in_whichever_block():
    column, out = Blocked((3,), np.float32).grow(3 * BLOCK), np.zeros(LANES, np.float32)
    column[np.arange(3 * BLOCK)] = np.arange(9 * BLOCK).reshape(-1, 3)
    for row, other in ((5, 6), (6, 5), (1, 2 * BLOCK + 9), (3 * BLOCK - 7, 0)):
        write_first(row, other, column.by_address(), out)
        assert out[:3].tolist() == column[other].tolist()


def test_a_vector_of_the_last_row_may_be_read_beyond_its_block():
    column = Blocked((3,), np.float32).grow(BLOCK + 1)
    for block in column.blocks:
        assert block.base.size == block.size + SPARE
        assert not block.base[block.size :].any()


def test_parts_cover_every_row_once_in_the_order_given():
    rows = np.array([700, 3, 300, 2, 701, 4])
    seen = {b: (inside.tolist(), places.tolist()) for b, inside, places in Blocked((), "f4").parts(rows)}
    assert seen == {
        0: ([3, 2, 4], [1, 3, 5]),
        1: ([300 - BLOCK], [2]),
        2: ([700 - 2 * BLOCK, 701 - 2 * BLOCK], [0, 4]),
    }


def test_a_reused_row_holds_the_default_and_not_what_the_dead_left():
    world = World(seed=1)
    table = world.add_table("ant", Brain, dims={"weights": 3})
    table.occupy(3, 1, 0, {})
    table[Brain].weights[1] = 7.0
    table.cause[1] = 1
    table.vacate(table.doomed())
    assert table.occupy(1, 4, 1, {}).tolist() == [1]
    assert (table[Brain].weights[1] == 0.5).all()


def test_a_brain_is_hashed_handled_and_reordered_as_other_columns_are():
    world = World(seed=1)
    table = world.add_table("ant", Brain, dims={"weights": 3})
    table.occupy(3, 1, 0, {(Brain, "weights"): np.arange(18, dtype=np.float32).reshape(3, 3, 2)})
    before = world.digest()
    table.reorder(np.array([2, 0, 1]))
    assert table.uid[:3].tolist() == [3, 1, 2]
    assert table[Brain].weights[0].ravel().tolist() == [12, 13, 14, 15, 16, 17]
    assert world.digest() == before
    world.get(1, Brain).weights[0, 0] = 5
    assert world.digest() != before


def test_a_heavy_component_conforms():
    check_component(Brain)
