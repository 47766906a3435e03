"""Ledgers of energy and of every substance close, in shipped worlds and in worlds drawn at random."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ecs_eco import World
from ecs_eco.config.shipped import shipped
from ecs_eco.testing import check_world
from studies.common.ledgers import drawn, furthest_off


@pytest.mark.parametrize("name", shipped())
def test_the_ledgers_of_every_shipped_world_close(name):
    assert max(furthest_off(World.from_config(name, policies="random").run(40)).values()) < 1e-6


@pytest.mark.definition("3 chemical rules")
@settings(max_examples=10, derandomize=True, database=None, suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2**32))
def test_the_ledgers_of_worlds_drawn_at_random_close(seed):
    """The long form is the study `ledgers`."""
    off = furthest_off(World.from_config(drawn(seed), policies="random").run(30))
    assert set(off) == {"energy", "matter", "between"}
    assert max(off.values()) < 1e-6


@pytest.mark.parametrize("seed", [1, 2])
def test_matter_moves_alike_on_two_threads_in_any_order_of_rows_and_again(seed):
    check_world(lambda threads: World.from_config(drawn(seed), policies="random", threads=threads), ticks=30)


def test_the_lamb_keeps_books_of_what_it_breathes_sucks_and_burns():
    world = World.from_config("lamb", policies="random").run(20)
    page = {k: np.array(v) for k, v in world.recorder.matter_series().to_pydict().items()}
    oxygen = page["substance"] == "oxygen"
    assert page["reacted"][oxygen].max() < 0 < page["taken_up"][oxygen][1:].min()
