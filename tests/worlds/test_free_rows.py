"""Nothing that the rows of the dead still hold reaches a result."""

from pathlib import Path

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.config.shipped import shipped

ROOT = Path(__file__).parents[2]
EXAMPLES = [path for path in sorted((ROOT / "examples").glob("*.toml")) if "[space]" in path.read_text()]


def fill(world, value):
    """Write a value into the free rows of all columns of all components."""
    for table in world.tables.values():
        free = ~table.alive
        columns = [array for columns in table.columns.values() for array in vars(columns).values()]
        for array in [*columns, table.born]:
            array[free] = value if array.dtype.kind == "f" else np.array(-1).astype(array.dtype)


def run(world, value=None):
    """Let four ticks pass; return the digests."""
    if value is not None:
        world.before_tick.append(lambda: fill(world, value))
    world.run(4)
    return world.digest()


@pytest.mark.parametrize("name", [*shipped(), *map(str, EXAMPLES)], ids=lambda name: Path(name).stem)
def test_what_is_in_free_rows_changes_no_digest(name):
    config = load(name, trust=True)
    if config.archipelago is not None:
        pytest.skip("several worlds")
    world = World.from_config(config, seed=1, policies="untrained", record=False)
    world.run(2)
    for table in world.tables.values():  # rows that are free, before and between those of the living
        table.cause[table.by_uid()[::3]] = 1
    world.flush()
    copies = [world.copy() for _ in range(3)]
    expected = run(world)
    for copy, value in zip(copies, (np.nan, 1e30, -1.0), strict=True):
        with np.errstate(all="ignore"):
            assert run(copy, value) == expected, f"{value} in free rows"
