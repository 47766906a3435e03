"""Ledgers of energy and of every substance close, in shipped worlds and in worlds drawn at random."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from ecs_eco import System, World
from ecs_eco.components import Chemistry
from ecs_eco.config.shipped import shipped
from ecs_eco.engine.errors import ConfigError
from ecs_eco.testing import check_world, watch
from studies.common.ledgers import drawn, furthest_off


@pytest.mark.parametrize("name", shipped())
def test_the_ledgers_of_every_shipped_world_close(name):
    assert max(furthest_off(World.from_config(name, policies="random").run(40)).values()) < 1e-6


@pytest.mark.slow
@pytest.mark.definition("3 chemical rules")
@settings(max_examples=10, derandomize=True, database=None, suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2**32))
def test_the_ledgers_of_worlds_drawn_at_random_close(seed):
    """The long form is the `ledgers` study."""
    off = furthest_off(World.from_config(drawn(seed), policies="random").run(30))
    assert set(off) == {"energy", "matter", "between"}
    assert max(off.values()) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_matter_moves_alike_on_two_threads_in_any_order_of_rows_and_again(seed):
    check_world(lambda threads: World.from_config(drawn(seed), policies="random", threads=threads), ticks=30)


def test_the_lamb_keeps_books_of_what_it_breathes_sucks_and_burns():
    world = World.from_config("lamb", policies="random").run(20)
    page = {k: np.array(v) for k, v in world.recorder.matter_series().to_pydict().items()}
    oxygen = page["substance"] == "oxygen"
    assert page["reacted"][oxygen].max() < 0 < page["brought_in"][oxygen][1:].min()


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 5])
def test_matter_goes_on_from_a_checkpoint_with_its_books(seed, tmp_path):
    world = World.from_config(drawn(seed), policies="random").run(12)
    world.save(tmp_path / "here")
    again = World.restore(tmp_path / "here").run(8)
    copy = world.copy()
    copy.run(8)
    assert world.run(8).digest() == again.digest() == copy.digest()
    pages = [w.recorder.matter_series().to_pydict() for w in (world, again)]
    assert pages[0] == pages[1]
    assert max(furthest_off(again).values()) < 1e-6


def test_a_system_that_makes_matter_and_does_not_book_it_is_named():
    class Leak(System):
        """Salt comes from nowhere."""

        needs = (Chemistry,)
        phase = "interact"

        def update(self, table, world):
            table[Chemistry].molarity[: table.high, 2] *= np.float32(1.01)

    with pytest.raises(AssertionError, match=r"the ledger of salt in .* is off by"):
        watch(World.from_config(drawn(1), policies="random", systems=[Leak()]), 2)


@pytest.mark.slow
def test_the_debug_mode_finds_nothing_wrong_with_what_moves_matter(monkeypatch):
    monkeypatch.setenv("ECS_ECO_DEBUG", "1")
    World.from_config(drawn(1), policies="random").run(15)


def test_rates_may_change_while_they_live_but_ways_may_not_come_or_go():
    config = drawn(1)
    config["species"]["slug"]["reactions"] = [{"from": {"salt": 1.0}, "to": {}, "rate": 0.01}]
    world = World.from_config(config, policies="random")
    world.intervene(
        {"kind": "set", "set": {"species.slug.reactions.0.rate": 1e-9, "fields.gas_field.renewal": 0.5}}
    )
    world.run(2)
    assert world.tables["slug"].species.reactions[0].rate == 1e-9
    assert world.fields["gas_field"].renewal == 0.5
    with pytest.raises(ConfigError, match=r"reactions.*\n.*cannot change during a run"):
        world.intervene({"kind": "set", "set": {"species.slug.reactions": []}})
