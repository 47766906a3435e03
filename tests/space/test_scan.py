import os
import subprocess
import sys

import numpy as np
import pytest

from ecs_eco.components import Metabolism, Position
from ecs_eco.ecosystem import World
from ecs_eco.space import scan

LIMITS = [(0, np.float32(0), np.float32(1)), (1, np.float32(-2), np.float32(2))]


def _columns() -> tuple[list[np.ndarray], scan.ColumnGroup]:
    arrays = [np.zeros(4, np.float32), np.zeros((3, 2), np.float32)]
    return arrays, scan.ColumnGroup.of(
        [(table, array, low, high) for array, (table, low, high) in zip(arrays, LIMITS, strict=True)]
    )


@pytest.mark.parametrize("value", [np.nan, np.inf, 2.5, -2.5])
def test_a_value_outside_is_found_in_the_rows_in_use_alone(value):
    arrays, columns = _columns()
    arrays[1][2, 1] = value
    assert columns.first_outside(0, np.array([4, 2])) == -1
    assert columns.first_outside(0, np.array([4, 3])) == 1
    arrays[0][3] = value
    assert columns.first_outside(0, np.array([4, 3])) == 0
    assert columns.first_outside(1, np.array([4, 3])) == 1
    assert columns.first_outside(2, np.array([4, 3])) == -1
    assert columns.first_outside(0, np.array([0, 0])) == -1


def test_limits_themselves_are_inside():
    arrays, columns = _columns()
    arrays[0][:2], arrays[1][0] = (0, 1), (-2, 2)
    assert columns.first_outside(0, np.array([4, 3])) == -1


def _world() -> World:
    world = World((9.0, 9.0))
    world.add_table("moss", Position, Metabolism, capacity=4)
    world.spawn("moss", n=3)
    return world.run(1)


def test_a_column_that_grew_or_was_replaced_is_looked_at():
    world = _world()
    table = world.tables["moss"]
    world.spawn("moss", n=20)
    world.flush()
    table[Metabolism].energy[22] = np.nan
    with pytest.raises(ValueError, match=r"uid 23: Metabolism\.energy is nan"):
        world.run(1)
    table[Metabolism].energy[22] = 1.0
    table[Position].x = np.full(table.capacity, np.inf, np.float32)
    with pytest.raises(ValueError, match=r"uid 1: Position\.x is inf"):
        world.run(1)
    table[Position].x = np.ones(table.capacity, np.float32)
    table.cause[1] = 200
    with pytest.raises(ValueError, match="uid 2: cause of death 200"):
        world.run(1)


def test_a_table_and_a_component_that_were_added_are_looked_at():
    world = _world()
    world.add_table("fern", Position)
    world.spawn("fern")
    world.flush()
    world.tables["fern"].add_component(Metabolism)
    world.tables["fern"][Metabolism].energy[0] = np.inf
    with pytest.raises(ValueError, match=r"fern, uid 4: Metabolism\.energy is inf"):
        world.run(1)


def test_without_compilation_the_same_values_are_refused():
    script = (
        "import numpy as np\n"
        "from tests.space.test_scan import _columns\n"
        "arrays, columns = _columns()\n"
        "arrays[1][2, 1] = np.nan\n"
        "print(columns.first_outside(0, np.array([4, 3])), columns.first_outside(0, np.array([4, 2])))"
    )
    result = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert result.stdout.split() == ["1", "-1"]
