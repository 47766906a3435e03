import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Carrier, Load, Metabolism, Position
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.systems import Carry, Decide, Sense
from ecs_eco.testing import act, arrange, check_world

ANT = {
    "count": 2,
    "body": {"radius": 0.5},
    "metabolism": {"energy": 0.5, "energy_max": 1.0},
    "locomotion": {"speed": {"walk": 1.0}, "turn": 0.5},
    "carries": [{"object": "seed", "reach": 0.25, "cost": 0.125}],
    "sensors": [{"kind": "own", "property": "load", "scale": 0.002}, {"kind": "touch", "target": "nest"}],
    "actions": {"carry": ["take", "none", "drop"]},
    "default_action": {"carry": "none"},
    "happiness": {"formula": "load", "minimum": -1.0},
    "reflex": {"formulas": {"take": "0.5 - touch_nest", "drop": "touch_nest - 0.5"}},
}


def _hill(seeds=2, **ant):
    return {
        "format": 1,
        "name": "hill",
        "space": {"size": [20.0, 20.0]},
        "objects": {
            "seed": {"count": seeds, "body": {"radius": 0.25, "mass": 0.002, "opaque": False}},
            "nest": {"at": [[18.0, 18.0]], "body": {"radius": 0.5, "opaque": False}},
        },
        "species": {"ant": ANT | ant},
    }


def _tick(world):
    for system in (Sense, Decide, Carry):
        act(world, system)


def _column(world, name, component, field):
    table = world.tables[name]
    return getattr(table[component], field)[table.by_uid()].tolist()


@pytest.mark.definition("2 moves")
def test_an_ant_takes_the_nearest_seed_in_reach_carries_it_and_drops_it_at_the_nest():
    world = World.from_config(_hill(seeds=3))
    ant = arrange(world, "ant", x=[5, 15], y=5, energy=0.5)
    seed = arrange(world, "seed", x=[5.75, 4.5, 16.25], y=5)  # in reach up to 1 m
    _tick(world)
    uids = seed.uid[seed.by_uid()]
    assert _column(world, "ant", Load, "object") == [uids[1], 0]
    assert _column(world, "ant", Load, "mass") == [np.float32(0.002), 0]
    assert _column(world, "seed", Carrier, "uid") == [0, ant.uid[ant.by_uid()][0], 0]
    assert _column(world, "ant", Metabolism, "energy") == [0.375, 0.5]
    assert _column(world, "ant", Metabolism, "burnt") == [0.125, 0]
    arrange(world, "ant", x=[7, 15], y=[8, 5], heading=1.5)
    _tick(world)
    assert [c[1] for c in (_column(world, "seed", Position, f) for f in ("x", "y", "heading"))] == [7, 8, 1.5]
    assert sorted(world.tables["ant"].species.nerves.x[:, 0].tolist()) == [0, pytest.approx(1)]  # it feels it
    arrange(world, "ant", x=[17.5, 15], y=[18, 5])
    _tick(world)
    assert _column(world, "ant", Load, "object") == [0, 0]
    assert _column(world, "ant", Load, "mass") == [0, 0]
    assert _column(world, "seed", Carrier, "uid") == [0, 0, 0]
    assert _column(world, "seed", Position, "x")[1] == 7  # it lies where it was brought to before


def test_one_seed_goes_to_the_nearest():
    world = World.from_config(_hill(count=4))
    arrange(world, "ant", x=[4.5, 5.75, 14.75, 15.5], y=5)
    seed = arrange(world, "seed", x=[5, 15], y=5)
    _tick(world)
    first, second = seed.uid[seed.by_uid()].tolist()
    assert _column(world, "ant", Load, "object") == [first, 0, second, 0]


@pytest.mark.parametrize("near", ["ant", "bee"])
def test_one_seed_goes_to_the_nearest_carrier_of_all_species_and_equals_share_by_lot(near):
    config = _hill(count=40)
    config["species"]["bee"] = config["species"]["ant"]
    config["objects"]["seed"]["at"] = []
    config["objects"]["seed"]["count"] = 40
    world = World.from_config(config)
    x, y = np.arange(40) % 8 * 2.5 + 1, np.arange(40) // 8 * 2.0 + 1
    for name, side in (("ant", 0.25), ("bee", -0.25)):
        arrange(world, name, x=x + side, y=y)
    arrange(world, "seed", x=x, y=y)
    copy = world.copy()
    _tick(world)
    carried = {name: np.array(_column(world, name, Load, "object")) > 0 for name in ("ant", "bee")}
    assert (carried["ant"] ^ carried["bee"]).all()
    assert 10 <= carried["ant"].sum() <= 30
    arrange(copy, near, x=x + 0.125)
    _tick(copy)
    assert all(_column(copy, near, Load, "object"))


def test_who_carries_one_takes_no_other_and_nobody_takes_what_is_carried():
    world = World.from_config(_hill())
    arrange(world, "ant", x=[5, 15], y=5)
    seed = arrange(world, "seed", x=[5, 10], y=5)
    _tick(world)
    arrange(world, "ant", x=[10, 10.5], y=5)
    _tick(world)
    first, second = seed.uid[seed.by_uid()].tolist()
    assert _column(world, "ant", Load, "object") == [first, second]


def test_what_a_dying_ant_carries_falls_and_what_is_gone_is_carried_no_longer():
    world = World.from_config(_hill())
    ant = arrange(world, "ant", x=[5, 15], y=5)
    seed = arrange(world, "seed", x=[5, 15], y=5)
    _tick(world)
    world.kill(int(ant.uid[ant.by_uid()][0]))
    world.kill(int(seed.uid[seed.by_uid()][1]))
    world.flush()
    assert _column(world, "seed", Carrier, "uid") == [0]
    _tick(world)
    assert _column(world, "ant", Load, "object") == [0]
    assert _column(world, "ant", Load, "mass") == [0]


def test_without_actions_it_takes_what_it_can_and_keeps_it():
    world = World.from_config(_hill(actions={}, default_action={}, reflex=None, count=1))
    arrange(world, "ant", x=18, y=18, energy=0.5)
    seed = arrange(world, "seed", x=[18, 5], y=[18, 5])
    for _ in range(3):
        act(world, Carry)
    assert _column(world, "ant", Load, "object") == [seed.uid[seed.by_uid()][0]]
    assert _column(world, "ant", Metabolism, "energy") == [0.125]


def test_worlds_in_which_animals_carry_keep_their_promises(tmp_path):
    config = _hill(
        seeds=20,
        count=12,
        policy={"kind": "shared", "hidden": [4]},
        reflex=None,
        actions={"carry": ["take", "none", "drop"], "speed": ["walk"], "turn": ["left", "right"]},
        lethal=[{"property": "energy", "min": 0.0}, {"property": "age", "max": 30.0}],
        carries=[{"object": "seed", "reach": 0.25, "cost": 0.01}],
    )

    def make(threads=1):
        return World.from_config(config, policies="random", threads=threads, seed=2)

    check_world(make, ticks=25)
    whole, part = make().run(25), make().run(9)
    assert (part.tables["ant"][Load].object > 0).any()
    again = World.restore(part.save(tmp_path / "part.safetensors")).run(16)
    assert again.digest() == whole.digest()


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"carries": [{"object": "sed"}]}, "seed"),
        ({"carries": [{"object": "seed"}, {"object": "seed"}]}, "named twice"),
        ({"carries": [{"object": "seed", "reach": 15.0}]}, "above the maximum search"),
        ({"carries": []}, "it carries nothing"),
        ({"actions": {"carry": ["tak"]}, "default_action": {}, "reflex": None}, "take"),
    ],
)
def test_what_cannot_be_carried_is_refused(changes, fault):
    with pytest.raises(ConfigError, match=fault):
        load(_hill(**changes))


def test_what_is_solid_cannot_be_carried():
    config = _hill()
    config["objects"]["seed"]["body"]["solid"] = True
    with pytest.raises(ConfigError, match="is solid"):
        load(config)
