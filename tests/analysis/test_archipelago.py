"""The first sentences of an archipelago's report, from hand-made series."""

from types import SimpleNamespace

import numpy as np

from ecs_eco.analysis.archipelago import Islands, opening
from ecs_eco.analysis.runs import load_series

PLAN = SimpleNamespace(migration_probability={"deer": 0.1})
MOVES = np.array([[0, 0, 0, 1, 3], [1, 0, 1, 0, 2]])  # tick, species, from, to, number


def islands(**wolves):
    series = {name: load_series({"deer": [5, 5, 5, 5], "wolf": n}) for name, n in wolves.items()}
    return Islands({"tick": 4}, PLAN, series, MOVES)


def test_the_islands_where_a_species_died_out_come_first():
    lines, lost = opening(
        islands(north=[2, 1, 0, 0], south=[2, 0, 0, 0], west=[0, 0, 0, 0], east=[1, 1, 1, 1])
    )
    assert lost
    assert lines == [
        "wolf died out on 2 of 4 islands (south at tick 1 and north at tick 2).",
        "Migrants that arrived: 5 deer.",
    ]


def test_that_all_species_live_is_said_and_no_island_needs_all_species():
    lines, lost = opening(islands(north=[2, 1, 1, 1], west=[0, 0, 0, 0]))
    assert not lost
    assert lines[0] == "On each island, all species that it began with are alive after 4 ticks."
