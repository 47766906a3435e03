import numpy as np
import pytest

from ecs_eco.components import Position
from ecs_eco.systems import Collide
from ecs_eco.testing import act, arrange

SOLID = {"body": {"radius": 0.5, "solid": True}}


def _x(world, name="deer", axis="x"):
    table = world.tables[name]
    return table.field(Position, axis)[table.by_uid()].tolist()


def test_overlapping_bodies_part_by_half_of_the_overlap_each(meadow):
    world = meadow(count=3, **SOLID)
    arrange(world, "deer", x=[5, 5.5, 10], y=5)
    act(world, Collide)
    assert _x(world) == [4.75, 5.75, 10]
    assert _x(world, axis="y") == [5, 5, 5]


def test_a_body_between_two_is_pushed_from_both_sides_at_once(meadow):
    world = meadow(count=3, **SOLID)
    arrange(world, "deer", x=[5, 5.5, 5.75], y=5)
    act(world, Collide)
    # pairs overlap by .5, .25 and .75: first −.25 −.125, second +.25 −.375, third +.125 +.375
    assert _x(world) == pytest.approx([4.625, 5.375, 6.25])


def test_what_cannot_move_pushes_by_the_whole_overlap(meadow):
    rock = {"objects": {"rock": {"at": [[10.0, 10.0]], "body": {"radius": 2.0, "solid": True}}}}
    world = meadow(world=rock, **SOLID)
    arrange(world, "deer", x=[10, 10], y=[7.75, 13])
    act(world, Collide)
    assert _x(world, axis="y") == [7.5, 13]
    assert _x(world, "rock") == [10]


def test_the_soft_pass_through(meadow):
    world = meadow(grass={"body": {"radius": 0.25, "solid": False}}, **SOLID)
    arrange(world, "deer", x=[5, 9], y=5)
    arrange(world, "grass", x=[5.1, 9.1], y=5)
    act(world, Collide)
    assert _x(world) == [5, 9]


def test_concentric_bodies_part_by_their_uids(meadow):
    world = meadow(**SOLID)
    arrange(world, "deer", x=5, y=5)
    act(world, Collide)
    assert _x(world) == [4.5, 5.5]


def test_across_the_seam_and_not_into_rock(meadow):
    world = meadow(
        world={"terrain": {"cell": 1.0, "rocks": [{"at": [10.0, 10.0], "radius": 1.5}]}}, count=4, **SOLID
    )
    arrange(world, "deer", x=[19.75, 0.25, 8.9, 8.4], y=[5, 5, 10, 10])
    act(world, Collide)
    # the third would have been pushed into rock
    assert _x(world) == pytest.approx([19.5, 0.5, 8.9, 8.15], abs=1e-5)


@pytest.mark.parametrize("kind", ["rocks", "lakes"])
def test_nobody_is_pushed_over_a_small_rock_or_lake_and_who_is_in_one_comes_out(meadow, kind):
    mark = {"at": [10.0, 10.0], "radius": 0.4}
    world = meadow(
        count=2, world={"terrain": {"cell": 0.1, kind: [mark]}}, body={"radius": 1.0, "solid": True}
    )
    arrange(world, "deer", x=[9.5, 9.45], y=10)
    act(world, Collide)
    assert _x(world) == pytest.approx([9.5, 8.475])  # beyond it, 10.475, the first one would be
    arrange(world, "deer", x=[10.2, 10.1], y=10)
    act(world, Collide)
    assert _x(world) == pytest.approx([11.15, 9.15])


def test_larger_ones_of_a_kind_push_as_far_as_they_reach(meadow):
    world = meadow(**SOLID)
    arrange(world, "deer", x=[5, 8], y=5, radius=[2.0, 1.5])
    act(world, Collide)
    assert _x(world) == [4.75, 8.25]


@pytest.mark.parametrize(
    ("size", "edges"), [([12.0, 9.0], "torus"), ([12.0, 9.0], "walls"), ([8.0, 7.0, 6.0], "walls")]
)
def test_the_kernel_is_its_slow_twin(meadow, size, edges):
    rng = np.random.default_rng(5)
    n = 60
    world = meadow(world={"space": {"size": size, "edges": edges}}, count=n, **SOLID)
    at = np.array([rng.random(n) * s for s in (*size, 0.0)[:3]], np.float32)
    radius = rng.uniform(0.2, 0.6, n).astype(np.float32)
    arrange(world, "deer", x=at[0], y=at[1], z=at[2], radius=radius)
    act(world, Collide)
    a = at.T.astype(float)
    push = np.zeros((n, 3))
    for i in range(n):
        d = a[i] - a
        if edges == "torus":
            d[:, :2] -= np.array(size[:2]) * np.round(d[:, :2] / np.array(size[:2]))
        distance = np.linalg.norm(d, axis=1)
        depth = radius + radius[i] - distance
        for j in np.flatnonzero(depth > 0):
            if j != i:
                push[i] += 0.5 * depth[j] * d[j] / distance[j]
    there = a + push
    for axis, length in enumerate(size):
        there[:, axis] = (
            there[:, axis] % length if edges == "torus" and axis < 2 else there[:, axis].clip(0, length)
        )
    places = np.stack(
        [world.tables["deer"].field(Position, c)[world.tables["deer"].by_uid()] for c in "xyz"], 1
    )
    assert places == pytest.approx(there, abs=1e-4)
    assert (np.abs(push).max(axis=1) > 0).sum() > 10
