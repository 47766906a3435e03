"""A tick in two halves is the tick that it would be as a whole, and nothing else passes between them."""

import pytest

from ecs_eco import System, World
from ecs_eco.engine.errors import UnfinishedTick
from ecs_eco.engine.halves import Halves


class Note(System):
    def __init__(self, phase, said):
        super().__init__()
        self.phase, self.said = phase, said

    def process(self):
        self.said.append((self.world.tick, self.phase))


@pytest.fixture
def world():
    world, said = World(), []
    for phase in ("decide", "environment", "learn", "record"):
        world.add_system(Note(phase, said))
    world.said = said
    return world


def test_the_first_half_ends_before_a_phase_and_the_second_begins_with_it(world):
    halves = Halves("decide")
    halves.begin(world)
    assert world.said == [(0, "environment"), (0, "learn")]
    assert (world.tick, halves.begun, world.ticking) == (0, True, True)
    halves.begin(world)  # begun already
    halves.finish(world)
    assert world.said[2:] == [(0, "decide"), (0, "record")]
    assert (world.tick, halves.begun, world.ticking) == (1, False, False)
    world.run(1)
    assert [phase for tick, phase in world.said if tick == 1] == [phase for tick, phase in world.said[:4]]


@pytest.mark.parametrize("act", [lambda w: w.run(1), lambda w: w.save("x.npz"), lambda w: w.copy()])
def test_between_the_halves_a_world_is_neither_run_nor_saved_nor_copied(world, act):
    Halves("decide").begin(world)
    with pytest.raises(RuntimeError, match="within a tick: tick 0 is in progress"):
        act(world)


def test_a_second_half_needs_a_first(world):
    with pytest.raises(RuntimeError, match="no tick has begun"):
        Halves("decide").finish(world)


def test_hooks_are_called_before_the_first_half_and_an_error_of_theirs_leaves_the_world_whole(world):
    world.before_tick.append(lambda: world.said.append("hook"))
    halves = Halves("decide")
    halves.begin(world)
    halves.finish(world)
    assert world.said[0] == "hook"
    world.before_tick.append(lambda: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        halves.begin(world)
    world.before_tick.pop()
    halves.begin(world)
    halves.finish(world)
    assert world.tick == 2


@pytest.mark.parametrize(("phase", "system"), [("sense", 0), ("move", 1)])
def test_an_error_in_either_half_leaves_a_world_that_can_only_be_inspected(world, phase, system):
    class Fail(System):
        def process(self):
            raise ZeroDivisionError("by zero")

    world.add_system(Fail(), phase)
    halves = Halves("decide")
    if system:
        halves.begin(world)
    with pytest.raises(ZeroDivisionError):
        (halves.finish if system else halves.begin)(world)
    with pytest.raises(UnfinishedTick, match="ZeroDivisionError: by zero in Fail"):
        world.run(1)
    with pytest.raises(UnfinishedTick):
        halves.begin(world)
