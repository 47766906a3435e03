"""Deaths take effect alike, whether somebody wants to hear of them or not."""

import numpy as np
import pytest

from ecs_eco import World, component, f32


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
