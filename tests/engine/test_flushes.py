"""Deaths take effect alike with hooks and without; hooks get what their page lists."""

import re
from pathlib import Path

import numpy as np
import pytest

from ecs_eco import World, component, f32
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
