"""The debug mode: when it is on, and that it changes no result."""

import numpy as np
import pytest

from ecs_eco import System, World
from ecs_eco.components import Metabolism, Nervous, Position
from ecs_eco.config.shipped import shipped
from ecs_eco.debug import DebugError
from ecs_eco.testing import act
from ecs_eco.testing.states import shuffle
from tests.debug.wrong import Wool, deer, does
from tests.worlds.herd import HERD

F = np.float32


def _in_both(monkeypatch, make, ticks):
    monkeypatch.delenv("ECS_ECO_DEBUG", raising=False)
    plain = make().run(ticks)
    assert plain.debug is None
    monkeypatch.setenv("ECS_ECO_DEBUG", "1")
    watched = make()
    assert watched.debug is not None
    watched.run(ticks)
    assert watched.digest() == plain.digest()
    assert watched.series().equals(plain.series())
    return plain


@pytest.mark.slow
@pytest.mark.parametrize("name", list(shipped()))
def test_a_shipped_world_has_the_same_result_in_debug_mode(monkeypatch, name):
    assert _in_both(monkeypatch, lambda: World.from_config(name), 20).tick == 20


@pytest.mark.slow
def test_genomes_individual_brains_and_births_have_the_same_result_in_debug_mode(monkeypatch):
    world = _in_both(monkeypatch, lambda: World.from_config(HERD), 50)
    assert world.next_uid > 200


@pytest.mark.slow
def test_the_world_with_everything_has_the_same_result_in_debug_mode(monkeypatch, menagerie):
    def make():
        return World.from_config(menagerie(), policies="untrained", learn=True)

    _in_both(monkeypatch, make, 50)


def test_a_learner_has_the_same_state_whatever_lay_in_memory_before(monkeypatch):
    """The advantages of a rollout that is not full are zero, not what the memory held."""
    digests = []
    for size in (10, 1000):
        junk = [np.full(size * 100, 7.7, F) for _ in range(50)]
        del junk
        digests.append(World.from_config("predator-prey", policies="untrained", learn=True).run(10).digest())
    assert digests[0] == digests[1]


@pytest.mark.parametrize("value", ["", "0"])
def test_debug_mode_is_off_by_default_and_by_0(monkeypatch, value):
    monkeypatch.setenv("ECS_ECO_DEBUG", value)
    world = World()
    assert world.debug is None
    table = world.add_table("sheep", Wool)
    world.spawn("sheep")
    world.flush()
    assert world.get(1, Wool)._columns is table[Wool]


def test_the_mode_is_chosen_when_a_world_is_made(monkeypatch, meadow):
    monkeypatch.setenv("ECS_ECO_DEBUG", "1")
    world = meadow(options={"systems": [does(lambda t, w: t[Metabolism].energy.fill(np.nan))]})
    monkeypatch.delenv("ECS_ECO_DEBUG")
    with pytest.raises(DebugError, match="nan"):
        world.run(5)


def test_a_system_that_grows_a_table_by_a_flush_of_its_own_is_right(debug, meadow):
    """As an intervention does: what it does before and after the flush is checked apart."""

    def add(table, world):
        world.spawn("deer", Position(x=1.0), Metabolism(energy=0.25), n=200)
        world.kill(deer(world)[0])
        world.flush()

    world = meadow(options={"systems": [does(add)]}).run(4)
    assert world.table("deer").n == 201


def test_a_system_that_acts_outside_a_tick_is_checked_too(debug, meadow):
    world = meadow(
        options={"systems": [type("Wrong", (System,), {"needs": (Nervous,), "update": _poison})()]}
    )
    with pytest.raises(
        DebugError,
        match=r"after Wrong, tick 0, species 'deer': "
        rf"Nervous\.happiness of uid {deer(world)[0]} \(row 0\)",
    ):
        act(world, type(world.systems[-2]))
    assert world.debug.before is None
    shuffle(meadow()).run(3)


def _poison(self, table, world):
    table[Nervous].happiness[0] = np.nan
