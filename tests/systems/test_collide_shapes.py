import math

import numpy as np
import pytest

from ecs_eco.components import Nervous, Position, Velocity
from ecs_eco.systems import Collide, Move
from ecs_eco.testing import act, arrange, check_system

SOLID = {"body": {"radius": 0.5, "solid": True}}


def fence(*between, width=0.2, **rest):
    """A world with solid boxes from place to place."""
    body = {"shape": "box", "size": [1.0, width], "solid": True}
    return {"objects": {"fence": {"between": list(map(list, between)), "body": body}}, **rest}


def _at(world, name="deer"):
    p, rows = world.tables[name][Position], world.tables[name].by_uid()
    return np.stack([p.x[rows], p.y[rows]], 1)


@pytest.mark.definition("1 conformation")
def test_a_disc_is_pushed_out_of_a_box_along_the_shortest_way(meadow):
    world = meadow(count=4, world=fence((5.0, 10.0, 15.0, 10.0), width=2.0), **SOLID)
    # beside it, before its end, off its corner, and within it
    arrange(world, "deer", x=[8, 15.25, 15.3, 12], y=[11.25, 10, 11.4, 10.75])
    act(world, Collide)
    expected = [[8, 11.5], [15.5, 10], [15.3, 11.4], [12, 11.5]]
    assert _at(world).ravel() == pytest.approx(np.ravel(expected), abs=1e-5)
    assert _at(world, "fence").tolist() == [[10, 10]]


@pytest.mark.definition("1 conformation")
def test_two_capsules_part_by_half_of_the_overlap_each(meadow):
    world = meadow(body={"shape": "capsule", "radius": 0.5, "length": 3.0, "solid": True})
    arrange(world, "deer", x=[5, 5.5], y=[5, 5.5], heading=0)  # side by side, 0.5 m apart
    act(world, Collide)
    assert _at(world).ravel() == pytest.approx([5, 4.75, 5.5, 5.75])
    arrange(world, "deer", x=[5, 6.75], y=5, heading=[0, math.pi / 2])  # a tip 0.25 m deep in a flank
    act(world, Collide)
    assert _at(world).ravel() == pytest.approx([4.875, 5, 6.875, 5])


@pytest.mark.definition("1 conformation")
def test_across_the_seam_a_long_body_pushes_at_both_ends(meadow):
    world = meadow(count=3, world=fence((11.0, 5.0, 19.9, 5.0)), **SOLID)
    # it ends 0.1 m before the edge: 0.3 m beyond lies one, and one within reach of the other end
    arrange(world, "deer", x=[0.2, 10.75, 19.0], y=[5, 5, 4.8])
    act(world, Collide)
    assert _at(world).ravel() == pytest.approx([0.4, 5, 10.5, 5, 19.0, 4.4], abs=1e-5)


@pytest.mark.definition("1 conformation")
@pytest.mark.parametrize("width", [0.02, 0.2, 2.0])
def test_nobody_runs_through_a_fence_however_fast(meadow, width):
    way = {"speed": {"still": 0.0, "walk": 0.3, "run": 9.0}, "turn": 0.5}
    walled = {"size": [20.0, 20.0], "edges": "walls"}
    world = meadow(
        count=60, locomotion=way, **SOLID, world=fence((10.0, 0.5, 10.0, 19.5), width=width, space=walled)
    )
    rng = np.random.default_rng(3)
    arrange(
        world, "deer", x=rng.uniform(1, 8, 60), y=rng.uniform(4, 16, 60), heading=rng.uniform(-0.6, 0.6, 60)
    )
    gait = rng.integers(1, 3, 60)
    decision = np.zeros((60, 7), np.uint8)
    decision[np.arange(60), gait], decision[:, 4] = 1, 1
    for _ in range(8):  # they crowd at the fence and push each other
        world.tables["deer"][Nervous].decision[world.tables["deer"].by_uid()] = decision
        act(world, Move)
        act(world, Collide)
        at = _at(world)
        beside = (at[:, 1] > 0.5) & (at[:, 1] < 19.5)
        assert (at[beside, 0] < 10).all()
    assert at[:, 0].max() > 8


@pytest.mark.definition("1 conformation")
def test_a_way_ends_at_the_fence_and_the_speed_is_that_of_the_way(meadow):
    world = meadow(world=fence((10.0, 5.0, 10.0, 15.0)), **SOLID)
    table = arrange(world, "deer", x=[8.9, 8.9], y=[10, 18], heading=0)
    table[Nervous].decision[table.by_uid()] = [0, 0, 1, 0, 1, 0, 0]
    act(world, Move)
    # 1 m to the side of the fence, of 3 m; the other one passes beside it
    assert _at(world).ravel() == pytest.approx([9.9, 10, 11.9, 18], abs=1e-3)
    assert table[Velocity].speed[table.by_uid()] == pytest.approx([1, 3], abs=1e-3)
    act(world, Collide)
    assert _at(world).ravel() == pytest.approx([9.4, 10, 11.9, 18], abs=1e-3)


@pytest.mark.parametrize(("speed", "pace"), [(9.9, 1.0), (10.0, 1.0), (6.0, 2.0), (10.0, 4.0), (10.0, 50.0)])
def test_a_step_of_half_a_torus_and_more_ends_at_the_fence(meadow, speed, pace):
    road = {"cell": 1.0, "roads": [{"line": [[0.0, 10.0], [20.0, 10.0]], "width": 40.0, "pace": pace}]}
    way = {"speed": {"still": 0.0, "walk": 1.0, "run": speed}, "turn": 0.5}
    more = {} if pace == 1 else {"terrain": road}
    world = meadow(count=3, locomotion=way, world=fence((12.0, 0.0, 12.0, 20.0), **more), **SOLID)
    table = arrange(world, "deer", x=[3, 11, 4], y=[5, 10, 15], heading=[0, 0, math.pi])
    table[Nervous].decision[table.by_uid()] = [0, 0, 1, 0, 1, 0, 0]
    act(world, Move)
    # those that go east end at 11.9, the one that goes west on the other side, 12.1, if it comes so far
    west = 12.1 if speed * pace > 11.9 else (4 - speed * pace) % 20
    assert _at(world)[:, 0] == pytest.approx([11.9, 11.9, west], abs=0.02)
    gone = table[Velocity].speed[table.by_uid()]
    assert gone == pytest.approx([8.9, 0.9, min(speed * pace, 11.9)], abs=0.02)


def test_at_the_edge_of_the_space_nobody_is_pushed_around_the_end_of_a_fence(meadow):
    walled = {"size": [20.0, 20.0], "edges": "walls"}
    world = meadow(
        count=5, world=fence((10.0, 0.0, 10.0, 20.0), space=walled), body={"radius": 1.0, "solid": True}
    )
    arrange(world, "deer", x=[9.8, 9.1, 9.2, 9.0, 9.1], y=[0.0, 0.5, 0.4, 0.3, 0.2])
    act(world, Collide)
    at = _at(world)
    assert at[:, 0].max() < 10
    assert at[0] == pytest.approx([9.9, 0.0], abs=1e-3)  # all push it out of the space, which ends the way


@pytest.mark.definition("1 conformation")
def test_a_road_and_the_soft_stop_nobody(meadow):
    road = {
        "objects": {
            "road": {
                "between": [[10.0, 0.0, 10.0, 20.0]],
                "body": {"shape": "box", "size": [1.0, 2.0, 0.01], "solid": False, "opaque": False},
            }
        }
    }
    soft = {"body": {"radius": 0.5, "solid": False}}
    for world in (meadow(world=road, **SOLID), meadow(world=fence((10.0, 5.0, 10.0, 15.0)), **soft)):
        table = arrange(world, "deer", x=[8.5, 8.5], y=[7, 12], heading=0)
        table[Nervous].decision[table.by_uid()] = [0, 0, 1, 0, 1, 0, 0]
        act(world, Move)
        act(world, Collide)
        assert _at(world).ravel() == pytest.approx([11.5, 7, 11.5, 12], abs=1e-5)


def test_in_a_volume_bodies_part_upwards_too(meadow):
    body = {"shape": "box", "size": [8.0, 6.0, 1.0], "solid": True}
    slab = {
        "space": {"size": [20.0, 20.0, 10.0]},
        "objects": {"slab": {"at": [[10.0, 10.0, 5.0]], "heading": [0.5], "body": body}},
    }
    world = meadow(world=slab, **SOLID)
    arrange(world, "deer", x=10, y=[10, 11], z=[5.75, 4.5])
    act(world, Collide)
    table = world.tables["deer"]
    assert table[Position].z[table.by_uid()] == pytest.approx([6, 4])


def test_the_system_conforms_with_shapes(meadow):
    shapes = fence((4.0, 4.0, 16.0, 7.0), (10.0, 19.9, 13.0, 2.0))
    body = {"shape": "capsule", "radius": 0.3, "length": 1.5, "solid": True}

    def make(threads):
        return meadow(count=50, body=body, world=shapes, options={"threads": threads})

    for system in (Collide, Move):
        check_system(system, make)
