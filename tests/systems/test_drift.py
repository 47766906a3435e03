import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.systems import Drift
from ecs_eco.testing import act, arrange


def _sea(meadow, **water):
    return meadow(world={"space": {"size": [20.0, 20.0, 10.0]}, "water": water, "dt": 0.5}, count=3)


def test_a_current_by_depth_is_linear_between_its_depths(meadow):
    world = _sea(
        meadow, current=[{"depth": 2.0, "velocity": [1.0, 0.0]}, {"depth": 6.0, "velocity": [0.0, -2.0]}]
    )
    table = arrange(world, "deer", x=10, y=10, z=[9.0, 7.0, 1.0])  # depths 1, 3 and 9
    act(world, Drift)
    p, rows = table[Position], table.by_uid()
    assert p.x[rows] == pytest.approx([10.5, 10.375, 10.0])
    assert p.y[rows] == pytest.approx([10.0, 9.75, 9.0])
    assert p.z[rows].tolist() == [9.0, 7.0, 1.0]


def test_bodies_sink_or_rise_to_the_bottom_or_the_surface_and_no_further(meadow):
    world = meadow(world={"space": {"size": [20.0, 20.0, 10.0]}, "dt": 1.0}, count=3, body={"sinking": 1.0})
    table = arrange(world, "deer", z=[5.0, 0.3, 0.0])
    act(world, Drift)
    assert table[Position].z[table.by_uid()].tolist() == [4.0, 0.0, 0.0]
    world = meadow(world={"space": {"size": [20.0, 20.0, 10.0]}, "dt": 1.0}, count=2, body={"sinking": -1.0})
    table = arrange(world, "deer", z=[5.0, 9.5])
    act(world, Drift)
    assert table[Position].z[table.by_uid()].tolist() == [
        6.0,
        float(np.nextafter(np.float32(10.0), np.float32(0))),
    ]


def test_a_current_carries_nobody_into_rock_or_over_it(meadow):
    for speed in (2.0, 8.0):
        water = {"current": [{"depth": 0.0, "velocity": [speed, 0.0]}]}
        world = meadow(
            world={
                "space": {"size": [20.0, 20.0, 10.0]},
                "dt": 1.0,
                "water": water,
                "terrain": {"cell": 0.5, "rocks": [{"at": [10.0, 10.0], "radius": 1.0}]},
            },
            count=3,
        )
        table = arrange(world, "deer", x=[8.0, 8.0, 10.0], y=[10.0, 15.0, 10.0], z=5.0)
        act(world, Drift)
        assert table[Position].x[table.by_uid()].tolist() == [8.0, 8.0 + speed, 10.0 + speed]


def test_a_current_carries_a_solid_body_as_far_as_a_solid_box(meadow):
    water = {"current": [{"depth": 0.0, "velocity": [4.0, 0.0]}]}
    net = {
        "at": [[10.0, 10.0, 5.0], [10.0, 14.0, 5.0]],
        "body": {"shape": "box", "size": [0.2, 2.0, 2.0], "solid": True},
    }
    for solid, end in ((True, 9.9), (False, 12.0)):
        world = meadow(
            world={"space": {"size": [20.0, 20.0, 10.0]}, "dt": 1.0, "water": water, "objects": {"net": net}},
            count=2,
            body={"radius": 0.5, "solid": solid},
        )
        table = arrange(world, "deer", x=8.0, y=[10.0, 4.0], z=5.0)
        drift = next(s for s in world.systems if isinstance(s, Drift))
        drift.world = world
        drift.update(table, world)
        assert table[Position].x[table.by_uid()] == pytest.approx([end, 12.0], abs=1e-3)


def whirl(world, x, y, z):
    """Return a current around the middle, upward everywhere."""
    return 10.0 - y, x - 10.0, np.full(x.size, 1.0)


def test_a_current_may_be_a_function(meadow):
    world = _sea(meadow, current_function=whirl)
    table = arrange(world, "deer", x=[10.0, 12.0, 10.0], y=[10.0, 10.0, 9.0], z=[2.0, 2.0, 9.8])
    act(world, Drift)
    p, rows = table[Position], table.by_uid()
    assert p.x[rows] == pytest.approx([10.0, 12.0, 10.5])
    assert p.y[rows] == pytest.approx([10.0, 11.0, 9.0])
    assert p.z[rows] == pytest.approx([2.5, 2.5, 10.0])
    assert p.z.max() < 10.0


def torrent(world, x, y, z):
    return np.where(x < 8, np.float32(FLOW["u"]), 0), 0, 0


FLOW = {"u": 0.0}


@pytest.mark.parametrize("u", [9.0, 12.0, 19.0, 44.0])  # half a torus is 10 m
@pytest.mark.parametrize("barrier", ["box", "rock"])
def test_a_current_that_carries_bodies_around_the_torus_stops_at_barriers(meadow, barrier, u, monkeypatch):
    monkeypatch.setitem(FLOW, "u", u)
    space = {"size": [20.0, 20.0, 10.0], "edges": "torus"}
    world = {"space": space, "water": {"current_function": torrent}, "dt": 1.0}
    if barrier == "rock":
        world["terrain"] = {"cell": 0.5, "rocks": [{"at": [12.0, 10.0], "radius": 2.0}]}
    else:
        shape = {"shape": "box", "size": [1.0, 0.2, 9.0], "solid": True}
        world["objects"] = {"hedge": {"between": [[12.0, 0.0, 12.0, 20.0]], "body": shape}}
    made = meadow(world=world, count=1, body={"solid": True, "radius": 0.25})
    table = arrange(made, "deer", x=5.0, y=10.2, z=3.0)
    act(made, Drift)
    x = table[Position].x[table.by_uid()][0]
    assert x == pytest.approx(11.9, abs=0.01) if barrier == "box" else x == 5


def _coarse(low, high):
    """Numbers in a range, none so near to 0 that a world refuses them as too small for float32."""
    return st.floats(low, high, width=32).map(lambda v: v if abs(v) > 1e-3 else 0.0)


@pytest.mark.slow
@settings(max_examples=15, derandomize=True, database=None)
@given(
    speed=_coarse(0, 1.5),
    pitch=_coarse(0, 1.5),
    sinking=_coarse(-3, 3),
    drag=st.sampled_from([0.0, 0.5, 9.0]),
    flow=_coarse(-2, 2),
    dt=st.sampled_from([0.25, 1.0, 2.0]),
    edges=st.sampled_from(["torus", "walls"]),
    seed=st.integers(0, 99),
)
def test_nothing_swims_through_the_surface_or_the_bottom(speed, pitch, sinking, drag, dt, edges, seed, flow):
    fish = {
        "count": 30,
        "body": {"radius": 0.1, "sinking": sinking},
        "locomotion": {"speed": {"swim": speed}, "pitch": pitch or 0.1, "drag": drag, "turn": 1.0},
        "sensors": [{"kind": "own", "property": "energy"}],
        "happiness": {"formula": "energy", "minimum": 0.0},
        "actions": {"speed": ["swim"], "turn": ["left", "none", "right"], "climb": ["up", "none", "down"]},
        "policy": {"kind": "shared", "hidden": [4]},
    }
    water = {"current": [{"depth": 0.0, "velocity": [flow, 0.0]}, {"depth": 5.0, "velocity": [0.0, flow]}]}
    space = {"size": [21.0, 22.0, 6.0], "edges": edges}
    config = {
        "format": 1,
        "name": "tank",
        "dt": dt,
        "space": space,
        "water": water,
        "species": {"fish": fish},
    }
    world = World.from_config(config, seed=seed, policies="random")
    for _ in range(12):
        world.run(5)
        p, rows = world.tables["fish"][Position], world.tables["fish"].rows()
        for axis, length in zip((p.x, p.y, p.z), (21.0, 22.0, 6.0), strict=True):
            assert np.isfinite(axis[rows]).all()
            assert (axis[rows] >= 0).all()
            assert (axis[rows] < length).all()
