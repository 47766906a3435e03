"""Deaths take effect alike, whether somebody wants to hear of them or not."""

import numpy as np
import pytest

from ecs_eco import World, component, f32
from ecs_eco.components import Position
from ecs_eco.engine.flushes import arrive, depart


@component
class Weight:
    mass: f32 = 1.0


@pytest.mark.parametrize("n", [1, 7, 8, 9, 64, 100])
def test_deaths_of_which_nobody_hears_free_the_same_rows(n):
    rng, worlds = np.random.default_rng(n), [World((10, 10)) for _ in range(2)]
    heard = []
    worlds[0].on_death.append(lambda table, rows: heard.append(rows.size))
    dying = {name: rng.random(n) < share for name, share in (("ant", 0.3), ("bee", 0.0), ("cow", 1.0))}
    for world in worlds:
        for name, which in dying.items():
            world.add_table(name, *([Weight] if name != "cow" else []))
            world.spawn(name, n=n)
            world.flush()
            world.tables[name].cause[:n][which] = 1
        world.flush()
    for one, other in zip(*(world.tables.values() for world in worlds), strict=True):
        assert (one.n, one.high, one.version) == (other.n, other.high, other.version)
        assert not one.cause.any()
        assert not other.cause.any()
        assert np.array_equal(one.alive, other.alive)
        assert np.array_equal(one.uid, other.uid)
    assert sum(heard) == sum(int(which.sum()) for which in dying.values())


@pytest.fixture
def herd():
    world = World((50.0, 50.0), seed=1)
    world.add_table("sheep", Position, Weight)
    world.spawn("sheep", Position(x=1.0), n=10)
    world.flush()
    return world


def _birth(world):
    world.spawn("sheep", Position(), n=1)
    world.flush()


def _death(world):
    world.kill(1)
    world.flush()


@pytest.mark.parametrize(("name", "event"), [
    ("before_tick", lambda world: world.run(1)), ("on_birth", _birth), ("on_death", _death),
    ("on_departure", lambda world: depart(world, world.tables["sheep"], np.array([0]), np.array([1]))),
    ("on_arrival", lambda world: arrive(world, world.tables["sheep"], np.array([99], np.uint64),
                                        np.zeros(1, np.int64), {}, np.array([1]))),
])  # fmt: skip
def test_a_hook_that_removes_itself_or_another_silences_none(herd, name, event):
    hooks, called = getattr(herd, name), []

    def once(*_):
        called.append("once")
        hooks.remove(once)
        hooks.remove(other)

    def other(*_):
        called.append("other")

    hooks += [once, other]
    event(herd)
    assert called == ["once", "other"]
    assert hooks == []


def test_a_loop_over_the_living_leaves_out_those_that_die_in_it_and_the_newborn_in_their_rows(herd):
    seen = []
    for uid, position in herd.each(Position):
        if uid == 3:
            herd.kill(7)
            herd.flush()
            herd.spawn("sheep", Position(x=40.0))  # 11, in the row of 7
            herd.flush()
            herd.tables["sheep"].reorder(herd.tables["sheep"].rows()[::-1])
        seen.append(uid)
        position.x = float(uid)
    assert seen == [1, 2, 3, 4, 5, 6, 8, 9, 10]
    assert herd.get(11, Position).x == 40.0
    assert [herd.get(uid, Position).x for uid in (4, 10)] == [4.0, 10.0]
