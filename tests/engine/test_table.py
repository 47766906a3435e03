import numpy as np
import pytest

from ecs_eco import Table, component, f32, i32


@component
class Place:
    """Where."""

    x: f32 = 1.0
    y: f32 = 2.0


@component
class Mark:
    """What is written on it."""

    digits: i32[2] = 3


def _table(n=4, capacity=4):
    table = Table("ant", (Place,), capacity=capacity)
    table.occupy(n, 10, 0, {(Place, "x"): np.arange(n, dtype=np.float32)})
    return table


def _doom(table, *rows):
    table.cause[list(rows)] = 1
    table.vacate(table.doomed())


def test_newborn_take_the_lowest_free_rows_and_new_uids():
    table = _table(4, capacity=8)
    _doom(table, 2, 0)
    assert (table.n, len(table), table.high, table.rows().tolist(), table.uid[:4].tolist()) == (
        2,
        2,
        4,
        [1, 3],
        [0, 11, 0, 13],
    )
    rows = table.occupy(3, 14, 7, {})
    assert rows.tolist() == [0, 2, 4]
    assert table.uid[:5].tolist() == [14, 11, 15, 13, 16]
    assert table.born[:5].tolist() == [7, 0, 7, 0, 7]
    assert table[Place].x[:5].tolist() == [1, 1, 1, 3, 1]  # defaults, nothing of the dead
    assert (table.n, table.high) == (5, 5)


def test_rows_at_and_beyond_high_are_free():
    table = _table(4)
    _doom(table, 3, 1)
    assert table.high == 3
    _doom(table, 0, 2)
    assert (table.high, table.n, table.rows().size) == (0, 0, 0)


def test_the_living_come_in_the_order_of_rows_or_of_uids():
    table = _table(4)
    table.uid[:4] = [13, 10, 12, 11]
    table.cause[[0, 2, 3]] = 1
    assert table.doomed().tolist() == [0, 2, 3]
    assert table.rows().tolist() == [0, 1, 2, 3]
    assert table.by_uid().tolist() == [1, 3, 2, 0]


def test_growing_keeps_values_and_handles_valid():
    table = _table(4)
    handle, old = Place.attach(table[Place], 2), table[Place].x
    table.occupy(100, 14, 0, {})
    assert table.capacity == 104
    assert table[Place].x is not old
    assert table[Place].x[:5].tolist() == [0, 1, 2, 3, 1]
    assert handle.x == 2
    handle.x = 50
    assert table[Place].x[2] == 50
    assert table.nbytes > 104 * 8
    table.reserve(105)
    assert table.capacity == 208  # doubles at least


def test_a_component_added_later_reaches_the_living_with_the_values_given():
    table = _table(2)
    table.add_component(Mark, digits=[8, 9])
    assert table[Mark].digits[:2].tolist() == [[8, 9], [8, 9]]
    table.occupy(1, 20, 0, {})
    assert table[Mark].digits[2].tolist() == [8, 9]
    table.add_component(Mark, digits=5)  # already there: what newborn get
    table.occupy(1, 21, 0, {})
    assert table[Mark].digits[1:4].tolist() == [[8, 9], [8, 9], [5, 5]]


def test_reorder_moves_everything_of_an_entity():
    table = _table(4, capacity=6)
    _doom(table, 1)
    table.killer[3] = 5
    version = table.version
    table.reorder(np.array([3, 0, 2]))
    assert table.uid.tolist() == [13, 10, 12, 0, 0, 0]
    assert table[Place].x[:3].tolist() == [3, 0, 2]
    assert table.alive.tolist() == [True] * 3 + [False] * 3
    assert (table.killer[0], table.high, table.n) == (5, 3, 3)
    assert table.version > version


def test_a_component_that_is_not_there_names_those_that_are():
    table = _table()
    assert Place in table
    assert Mark not in table
    assert table.has((Place,))
    assert not table.has((Place, Mark))
    with pytest.raises(KeyError, match="table 'ant': unknown component 'Mark'; known: Place"):
        table[Mark]
    with pytest.raises(
        AttributeError, match=r"table 'ant' has no attribute 'x'; it is a column: table\[Place\].x"
    ):
        _ = table.x
    with pytest.raises(
        AttributeError, match=r"table 'ant' has no attribute 'hue'; its components are Place$"
    ):
        _ = table.hue
    with pytest.raises(TypeError, match="<class 'int'> is not a component; declare it with @component"):
        table.add_component(int)
    with pytest.raises(
        KeyError, match=r"Place in table .*ant.*: unknown field .*X.*; known: x, y; did you mean .*x"
    ):
        table.set_defaults(Place, X=1)
    with pytest.raises(ValueError, match="capacity is 0; it must be at least 1"):
        Table("ant", (), capacity=0)


def test_a_request_that_does_not_fit_is_refused_when_it_is_made():
    table, two = _table(), np.zeros(2, np.uint64)
    with pytest.raises(KeyError, match="unknown component 'Mark'"):
        table.request(two, {(Mark, "digits"): np.zeros((2, 2))})
    with pytest.raises(KeyError, match="unknown field 'z'"):
        table.request(two, {(Place, "z"): np.zeros(2)})
    with pytest.raises(ValueError, match=r"newborns of 'ant': Place.x has shape \(3,\); expected \(2,\)"):
        table.request(two, {(Place, "x"): np.zeros(3)})
    assert not table.births


def test_a_table_is_itself_alone_and_its_components_are_not_replaced():
    one, other = _table(), _table()
    assert one != other
    assert {one: "one", other: "other"}[other] == "other"
    with pytest.raises(TypeError, match="table 'ant': components cannot be replaced; write to their"):
        one[Place] = other[Place]
    one.add_component(Mark)
    assert list(one) == list(one.columns) == [Place, Mark]
    one.columns.pop(Mark)
    assert Mark not in one
    one.derived[Mark] = one[Place]
    assert Mark in one
    assert one.has((Place, Mark))
    assert list(one.columns) == [Place]
