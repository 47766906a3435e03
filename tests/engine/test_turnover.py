"""Deaths take effect alike with hooks and without; hooks get what their page lists."""

import re
from pathlib import Path

import numpy as np
import pytest

from ecs_eco import World, component, f32
from ecs_eco.components import Position
from ecs_eco.engine.turnover import arrive, depart


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


def test_each_hook_is_called_with_as_many_arguments_as_its_page_lists():
    page = (Path(__file__).parents[2] / "docs/how-to/extending.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(before_tick|on_\w+)` \| [^|]+ \| ([^|;]+)", page, re.MULTILINE)
    listed = {name: 0 if words.startswith("no ") else words.count(",") + 1 for name, words in rows}
    world, called = World((10, 10)), {}
    assert listed.keys() == {name for name in vars(world) if name == "before_tick" or name.startswith("on_")}
    for name in listed:
        getattr(world, name).append(lambda *given, name=name: called.setdefault(name, len(given)))
    table = world.add_table("ant", Weight)
    world.spawn("ant", n=2)
    world.run(1)
    depart(world, table, table.rows()[:1], np.ones(1, np.int64))
    arrive(world, table, np.array([9], np.uint64), np.zeros(1, np.int64), {}, np.ones(1, np.int64))
    world.kill(2, "culled")
    world.run(1)
    assert called == listed


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


@pytest.mark.parametrize(
    ("name", "event"),
    [
        ("before_tick", lambda world: world.run(1)),
        ("on_birth", _birth),
        ("on_death", _death),
        ("on_departure", lambda world: depart(world, world.tables["sheep"], np.array([0]), np.array([1]))),
        (
            "on_arrival",
            lambda world: arrive(
                world,
                world.tables["sheep"],
                np.array([99], np.uint64),
                np.zeros(1, np.int64),
                {},
                np.array([1]),
            ),
        ),
    ],
)
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
