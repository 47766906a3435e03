"""A world that was stopped within a tick says so; Ctrl-C waits for the end of the tick."""

import os
import signal

import numpy as np
import pytest

from ecs_eco import System, World
from ecs_eco.components import Biology, Metabolism, Position
from ecs_eco.engine.errors import UnfinishedTick
from ecs_eco.record import Recorder
from ecs_eco.systems import Intervene


class Trip(System):
    """Does something in the tick `at`."""

    def __init__(self, act, at=3):
        self.act, self.at = act, at

    def process(self):
        if self.world.tick == self.at:
            self.act()


def fail():
    raise ValueError("a stone\nin the way")


def press():
    os.kill(os.getpid(), signal.SIGINT)
    sum(range(1000))  # the interpreter looks for signals between two instructions


def ants(*systems):
    world = World((10.0, 10.0), seed=1, name="hill")
    world.add_table("ant", Position, Metabolism, Biology)
    world.spawn("ant", Position(x=1.0, y=2.0), n=5)
    for system in (Intervene(), *systems):
        world.add_system(system)
    return world


@pytest.fixture
def broken():
    world = ants(Trip(fail))
    with pytest.raises(ValueError, match="a stone"):
        world.run(9)
    return world


REFUSED = {
    "run": lambda w, p: w.run(1),
    "step": lambda w, p: w.step(),
    "flush": lambda w, p: w.flush(),
    "save": lambda w, p: w.save(p / "w.safetensors"),
    "digest": lambda w, p: w.digest(),
    "record": lambda w, p: Recorder(w),
    "copy": lambda w, p: w.copy(),
    "fork": lambda w, p: w.fork(seed=2),
    "intervene": lambda w, p: w.intervene({"kind": "cull", "species": "ant", "count": 1}),
}


@pytest.mark.parametrize("what", REFUSED)
def test_after_an_error_within_a_tick_a_world_is_refused(what, broken, tmp_path):
    stopped = (
        r"tick 3 began but did not finish \(ValueError: "
        r"a stone in the way in Trip\).*World.restore.*world.copy"
    )
    with pytest.raises(UnfinishedTick, match=stopped):
        REFUSED[what](broken, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_world_that_was_stopped_may_be_looked_at(broken):
    assert [uid for uid, _ in broken.each(Position)] == [1, 2, 3, 4, 5]
    assert broken.get(3, Position).x == 1.0
    assert "at tick 3" in repr(broken)


def test_an_error_in_births_names_them():
    world = ants()
    world.on_birth.append(lambda *_: fail())
    with pytest.raises(ValueError, match="a stone"):
        world.flush()
    with pytest.raises(UnfinishedTick, match="the flush before tick 0 began but did not finish"):
        world.run(1)


@pytest.mark.parametrize(
    ("hook", "named"),
    [("on_death", "deaths of the phase die"), ("on_birth", "births of the phase reproduce")],
)
def test_an_error_in_a_hook_is_placed_at_the_end_of_its_phase(hook, named):
    world = ants()
    world.run(3)
    getattr(world, hook).append(lambda *_: fail())
    world.kill(1)
    world.spawn("ant", Position(x=1.0, y=2.0))
    with pytest.raises(ValueError, match="a stone"):
        world.run(1)
    with pytest.raises(UnfinishedTick, match=f"tick 3 began but did not finish .* in the {named}"):
        world.run(1)


def test_an_error_between_ticks_leaves_a_whole_world():
    world = ants()
    world.run(2).before_tick.append(fail)
    with pytest.raises(ValueError, match="a stone"):
        world.run(1)
    world.before_tick.clear()
    assert world.run(3).digest() == ants().run(5).digest()


def test_within_a_tick_a_world_is_neither_run_nor_saved(tmp_path):
    world = ants()
    world.add_system(Trip(lambda: world.run(1)))
    with pytest.raises(RuntimeError, match="cannot run within a tick: tick 3 is in progress"):
        world.run(9)


def test_ctrl_c_waits_for_the_end_of_the_tick():
    before = signal.getsignal(signal.SIGINT)
    world = ants(Trip(press))
    with pytest.raises(KeyboardInterrupt):
        world.run(9)
    assert world.tick == 4
    assert signal.getsignal(signal.SIGINT) is before
    assert world.run(5).digest() == ants(Trip(int)).run(9).digest()


def test_a_second_ctrl_c_stops_at_once_and_the_world_says_so():
    world = ants(Trip(press), Trip(press))
    with pytest.raises(KeyboardInterrupt):
        world.run(9)
    with pytest.raises(
        UnfinishedTick, match=r"tick 3 began but did not finish \(KeyboardInterrupt in Trip\)"
    ):
        world.run(1)


def test_ctrl_c_between_ticks_stops_at_once():
    world = ants()
    world.before_tick.append(press)
    with pytest.raises(KeyboardInterrupt):
        world.run(9)
    world.before_tick.clear()
    assert world.run(9).digest() == ants().run(9).digest()


def test_a_handler_of_ones_own_is_asked_as_before():
    heard = []
    before = signal.signal(signal.SIGINT, lambda *_: heard.append(1))
    try:
        world = ants(Trip(press)).run(9)
    finally:
        signal.signal(signal.SIGINT, before)
    assert (heard, world.tick) == ([1], 9)


def test_after_an_error_nobody_is_at_work_on_the_world(monkeypatch):
    monkeypatch.setattr("ecs_eco.compiled.workers.PARALLEL_FROM", 0)
    done = np.zeros(2)

    def kernel(first, last):
        if first == 0:
            fail()
        sum(range(300_000))
        done[1] = 1

    world = World(threads=2)
    with pytest.raises(ValueError, match="a stone"):
        world.split(kernel, 4)
    assert done[1] == 1


def test_a_failed_load_leaves_a_world_that_says_so(tmp_path):
    class Picky(System):
        def process(self):
            pass

        def state(self):
            return {"n": np.zeros(1)}

        def load(self, state):
            fail()

    path = ants(Picky()).save(tmp_path / "w.safetensors")
    other = ants(Picky())
    with pytest.raises(ValueError, match="a stone"):
        other.load(path)
    with pytest.raises(UnfinishedTick, match=r"a load of .*w.safetensors began but did not finish"):
        other.digest()
