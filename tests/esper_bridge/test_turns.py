"""One thread has the worlds of a process; the viewer's own second world takes turns with it."""

import threading
import weakref

import esper
import pytest

from ecs_eco import World
from ecs_eco.esper_bridge import turns


def in_a_thread(work):
    """Return what the work returned, or the exception that it raised."""
    collected = []

    def run():
        try:
            collected.append(work())
        except BaseException as error:
            collected.append(error)

    thread = threading.Thread(target=run, name="other")
    thread.start()
    thread.join()
    return collected[0]


@pytest.fixture(autouse=True)
def alone(monkeypatch):
    """No world of another test counts."""
    monkeypatch.setattr(turns, "_worlds", weakref.WeakSet())


def test_a_world_of_another_thread_is_refused():
    here = World(name="mine")
    error = in_a_thread(lambda: World(name="theirs"))
    assert isinstance(error, RuntimeError)
    assert "world 'theirs': the thread 'MainThread' has the world 'mine'" in str(error)
    assert "processes" in str(error)
    assert here.run(1).tick == 1


def test_a_world_that_nobody_holds_or_whose_thread_is_over_refuses_nobody():
    World(name="forgotten")
    theirs = in_a_thread(lambda: World(name="theirs"))
    assert isinstance(theirs, World), theirs
    assert World(name="mine").run(1).tick == 1


def test_a_world_is_touched_by_its_own_thread_alone():
    world = World()
    for work in (lambda: world.run(1), world.__enter__):
        assert "only the thread that created a world may use it" in str(in_a_thread(work))


@pytest.mark.slow
@pytest.mark.parametrize("learn", [False, True])
def test_a_second_world_apart_takes_turns(learn):
    def make(seed):
        return World.from_config("predator-prey", seed=seed, policies="untrained", learn=learn)

    expected = [make(seed).run(30).digest() for seed in (1, 2)]
    apart = []

    def work():
        with turns.apart():
            for _ in range(3):
                with turns.turn:
                    world = make(2)
                for _ in range(30):
                    world.run(1)
                apart.append(world.digest())

    thread = threading.Thread(target=work)
    thread.start()
    mine = []
    while thread.is_alive() or not mine:
        world = make(1).run(15)
        with world:
            assert esper.current_world == world.context.name
            world.run(15)
            assert esper.current_world == world.context.name
        mine.append(world.digest())
    thread.join()
    assert set(mine) == {expected[0]}
    assert apart == [expected[1]] * 3


def test_whoever_waits_has_the_next_turn_however_soon_the_other_wants_it_again():
    """A thread that takes turns without a pause, a thousand times,
    leaves one to a thread that began to wait before."""
    waits, had = threading.Event(), []

    def other():
        waits.set()
        with turns.turn:
            had.append(count[0])

    thread, count = threading.Thread(target=other), [0]
    with turns.turn:
        thread.start()
        waits.wait()
        while not turns.turn.waiting:
            pass
    for count[0] in range(1000):
        if turns.turn.waiting:
            turns.turn.leave()
        with turns.turn:
            pass
    thread.join()
    assert had == [0]
