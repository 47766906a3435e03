"""Worlds in several threads run at the same time, but take turns to use esper."""

import faulthandler
import threading
from concurrent.futures import ThreadPoolExecutor

import esper
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.engine import world as engine
from ecs_eco.esper_bridge import turns, world as bridge


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


class Look(esper.Processor):
    """Asks esper which world it shows, for a while."""

    seen = frozenset()

    def process(self, *_):
        for _ in range(100):
            self.seen |= {esper.current_world}


def make(seed, learn=False):
    return World.from_config("predator-prey", seed=seed, policies="untrained", learn=learn, record=False)


def test_ticks_that_use_what_all_threads_share_need_a_turn():
    free = make(1)
    assert not free._needs_turns()
    free.before_tick.append([].clear)  # a method without a module
    assert free._needs_turns()
    small = {
        "species.goat.count": 5,
        "species.green.count": 5,
        "species.yellow.count": 5,
        "species.red.count": 5,
    }
    kernels = World.from_config(load("reflexes", small), policies="untrained")
    assert not kernels._needs_turns()
    with_random = load("reflexes", small | {"species.goat.genome.mutate": {"operator": "mutInversion"}})
    assert World.from_config(with_random, policies="untrained")._needs_turns()


def test_worlds_created_in_several_threads_at_once_all_enter():
    with ThreadPoolExecutor(8) as pool:
        worlds = [
            world for some in pool.map(lambda _: [World() for _ in range(50)], range(8)) for world in some
        ]
    assert len(worlds) == 400
    assert set(worlds) <= set(bridge._worlds)
    assert all(world.apart for world in worlds)


def test_a_world_made_in_another_thread_during_a_tick_leaves_esper_as_it_was():
    world, outside = World(), esper.current_world

    class Makes(esper.Processor):
        def process(self, *_):
            in_a_thread(World)

    world.add_system(Makes())
    world.run(1)
    assert esper.current_world == outside
    assert "" not in esper.list_worlds()


def test_a_world_of_another_thread_leaves_esper_as_it_was_between_its_ticks():
    outside, seen = esper.current_world, []

    def live():
        world = World()
        world.add_system(Look())
        world.before_tick.append(lambda: seen.append(esper.current_world))
        world.run(3)

    assert in_a_thread(live) is None
    assert seen == [outside] * 3


def test_a_world_is_touched_by_its_own_thread_alone():
    world = World()
    for work in (lambda: world.run(1), world.__enter__):
        assert "only the thread that created a world may use it" in str(in_a_thread(work))


def meet(barrier):
    """Wait for the other threads; if one does not come, print what all threads are doing."""
    try:
        barrier.wait(60)
    except threading.BrokenBarrierError:
        faulthandler.dump_traceback(all_threads=True)
        raise


@pytest.mark.slow
@pytest.mark.parametrize("learn", [False, True])
def test_worlds_of_two_threads_run_at_the_same_time_and_end_as_alone(learn, monkeypatch):
    expected = [make(seed, learn).run(70).digest() for seed in (1, 2)]
    both, pass_tick = threading.Barrier(2), engine.World._pass_tick

    def within(world):
        meet(both)  # both worlds are within a tick
        pass_tick(world)

    def live(seed):
        world = make(seed, learn)
        meet(both)
        return world.run(70).digest()

    monkeypatch.setattr(engine.World, "_pass_tick", within)
    with ThreadPoolExecutor(2) as threads:
        assert list(threads.map(live, (1, 2))) == expected


@pytest.mark.slow
def test_worlds_of_several_threads_take_turns_to_use_esper():
    def watched(seed):
        world = make(seed)
        return world, [world.add_system(Look(), phase) for phase in ("sense", "record") if seed < 3]

    expected = [watched(seed)[0].run(60).digest() for seed in (1, 2, 3)]
    made = threading.Barrier(3)

    def live(seed):
        world, looks = watched(seed)
        meet(made)
        world.run(30)
        if seed < 3:
            with world:
                assert esper.current_world == world.context.name
                world.run(10)
                assert esper.current_world == world.context.name
            assert all(look.seen == {world.context.name} for look in looks)
            world.run(20)
        else:
            world.run(30)
        return world.digest()

    with ThreadPoolExecutor(3) as threads:
        assert list(threads.map(live, (1, 2, 3))) == expected
    assert esper.current_world == "default"


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
