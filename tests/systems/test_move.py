import numpy as np
import pytest

from ecs_eco.components import Nervous, Position, Velocity
from ecs_eco.space import Space, Terrain
from ecs_eco.systems import Move
from ecs_eco.systems.move import free_way
from ecs_eco.testing import act, arrange

STILL, WALK, RUN = [1, 0, 0], [0, 1, 0], [0, 0, 1]
LEFT, NONE, RIGHT = [1, 0, 0], [0, 1, 0], [0, 0, 1]


def _moved(world, decision, **columns):
    """Arrange deer, let them move as decided, and return (x, y, heading) of each."""
    table = arrange(world, "deer", **columns)
    table[Nervous].decision[table.by_uid()] = decision
    act(world, Move)
    p, rows = table[Position], table.by_uid()
    return np.stack([p.x, p.y, p.heading], 1)[rows]


@pytest.mark.definition("3 physical rules")
def test_an_animal_turns_then_goes_ahead_and_pays_for_its_gait(meadow):
    world = meadow(count=4, world={"dt": 0.5})
    decision = [[*STILL, *NONE, 1], [*WALK, *LEFT, 1], [*RUN, *RIGHT, 0], [0] * 7]
    places = _moved(world, decision, x=10, y=10, heading=0.25)
    expected = [
        [10, 10, 0.25],
        [10 + 0.5 * np.cos(0.5), 10 + 0.5 * np.sin(0.5), 0.5],
        [11.5, 10, 0.0],
        [10, 10, 0.25],
    ]
    assert places.ravel() == pytest.approx(np.ravel(expected), abs=1e-5)
    v = world.tables["deer"][Velocity]
    rows = world.tables["deer"].by_uid()
    assert v.speed[rows].tolist() == [0, 1, 3, 0]
    assert v.cost[rows].tolist() == pytest.approx([0, 0.02, 0.1, 0])


def test_of_several_gaits_at_once_the_first_declared_is_taken_and_none_means_neutral(meadow):
    world = meadow(count=3, default_action={"speed": "walk", "turn": "none"})
    decision = [[0, 1, 1, *NONE, 0], [1, 0, 1, 1, 0, 1, 0], [0] * 7]
    places = _moved(world, decision, x=10, y=10, heading=0)
    assert places.ravel() == pytest.approx([11, 10, 0, 10, 10, 0.5, 11, 10, 0], abs=1e-6)


def test_without_a_neutral_gait_an_undecided_animal_stays(meadow):
    world = meadow(default_action={})
    assert _moved(world, [[0] * 7] * 2, x=10, y=10, heading=1).tolist() == [[10, 10, 1]] * 2


def test_around_a_torus_and_up_to_a_wall(meadow):
    for edges, x in (("torus", 2.0), ("walls", np.nextafter(np.float32(20), np.float32(0)))):
        world = meadow(world={"space": {"edges": edges}})
        places = _moved(world, [[*RUN, *NONE, 0]] * 2, x=[19, 1], y=10, heading=[0, np.pi])
        assert places[:, 0].tolist() == pytest.approx([x, 18.0 if edges == "torus" else 0.0], abs=1e-5)


def test_headings_stay_within_a_turn(meadow):
    world = meadow()
    places = _moved(world, [[*STILL, *LEFT, 0], [*STILL, *RIGHT, 0]], heading=[6.2, 0.1])
    assert places[:, 2].tolist() == pytest.approx([6.7 - 2 * np.pi, 2 * np.pi - 0.4], abs=1e-5)


@pytest.mark.parametrize("kind", ["rocks", "lakes"])
def test_water_and_rock_stop_walkers_who_pay_all_the_same(meadow, kind):
    world = meadow(world={"terrain": {"cell": 0.5, kind: [{"at": [10.0, 10.0], "radius": 2.0}]}}, count=3)
    places = _moved(world, [[*RUN, *NONE, 0]] * 3, x=[6.0, 3.0, 14.0], y=10, heading=0)
    # the first stops at the last quarter metre before it begins
    assert places[:, 0].tolist() == [7.75, 6.0, 17.0]
    v, rows = world.tables["deer"][Velocity], world.tables["deer"].by_uid()
    assert v.speed[rows].tolist() == [1.75, 3, 3]
    assert v.cost[rows].tolist() == pytest.approx([0.1] * 3)


def test_uphill_costs_more_and_downhill_no_less(meadow):
    terrain = {
        "cell": 0.5,
        "slope_cost": 4.0,
        "mountains": [{"at": [10.0, 10.0], "radius": 8.0, "height": 6.0}],
    }
    world = meadow(world={"terrain": terrain, "space": {"edges": "walls"}}, count=3)
    _moved(world, [[*WALK, *NONE, 0]] * 3, x=[5.5, 14.5, 0.5], y=10, heading=0)

    def height(x):  # smooth step of the share of the way to the top, at the centres of cells
        share = 1 - np.hypot(x - 10, 0.25) / 8
        return 6 * share**2 * (3 - 2 * share)

    rise = height(6.5) - height(5.5)
    cost = world.tables["deer"][Velocity].cost[world.tables["deer"].by_uid()]
    assert cost.tolist() == pytest.approx([0.02 * (1 + 4 * rise), 0.02, 0.02], rel=0.02)
    assert rise > 0.8


def test_in_a_volume_climbing_is_a_group_of_its_own(meadow):
    way = {
        "locomotion": {"climb": 2.0},
        "default_action": {"climb": "none"},
        "actions": {"climb": ["up", "none", "down"]},
    }
    world = meadow(world={"space": {"size": [20.0, 20.0, 10.0]}}, count=4, **way)
    table = arrange(world, "deer", z=[5, 5, 5, 9])
    climbs = [[1, 0, 0], [0, 0, 1], [0, 0, 0], [1, 0, 0]]
    table[Nervous].decision[table.by_uid()] = [[*STILL, *NONE, 0, *climb] for climb in climbs]
    act(world, Move)
    assert table[Position].z[table.by_uid()].tolist() == pytest.approx([7, 3, 5, 10], abs=1e-5)
    assert table[Position].z.max() < 10
    assert table[Velocity].climb[table.by_uid()].tolist() == [2, -2, 0, 2]


def _swimmers(meadow, count=4, dt=1.0, **locomotion):
    way = {
        "locomotion": {"pitch": float(np.pi / 6), **locomotion},
        "default_action": {"climb": "none"},
        "actions": {"climb": ["up", "none", "down"]},
    }
    return meadow(world={"space": {"size": [20.0, 20.0, 10.0]}, "dt": dt}, count=count, **way)


def test_with_a_pitch_it_swims_along_a_slope_at_the_speed_of_its_gait(meadow):
    world = _swimmers(meadow)
    table = arrange(world, "deer", x=10, y=10, z=5, heading=0)
    table[Nervous].decision[table.by_uid()] = [
        [*gait, *NONE, 0, *c]
        for gait, c in ((WALK, [1, 0, 0]), (RUN, [0, 0, 1]), (RUN, [0, 1, 0]), (STILL, [1, 0, 0]))
    ]
    act(world, Move)
    p, v, rows = table[Position], table[Velocity], table.by_uid()
    assert p.x[rows] == pytest.approx([10 + np.cos(np.pi / 6), 10 + 3 * np.cos(np.pi / 6), 13, 10])
    assert p.z[rows] == pytest.approx([5.5, 3.5, 5, 5])
    assert np.hypot(v.speed, v.climb)[rows] == pytest.approx([1, 3, 3, 0])


def test_drag_lets_speed_near_that_of_the_gait_as_the_exact_solution_says(meadow):
    world = _swimmers(meadow, count=2, dt=0.5, drag=2.0)
    table = arrange(world, "deer", x=10, y=10, z=5, heading=0, speed=[0, 3], climb=[0, 1])
    table[Nervous].decision[table.by_uid()] = [[*RUN, *NONE, 0, 0, 1, 0], [*STILL, *NONE, 0, 0, 1, 0]]
    act(world, Move)
    p, v, rows = table[Position], table[Velocity], table.by_uid()
    left = np.exp(-1.0)
    assert v.speed[rows] == pytest.approx([3 * (1 - left), 3 * left])
    assert v.climb[rows] == pytest.approx([0, left])
    t = np.linspace(0, 0.5, 20_001)  # the slow twin adds up small steps of dv/dt = drag (v_gait - v)
    way = np.trapezoid(3 * (1 - np.exp(-2 * t)), t)
    assert p.x[rows] == pytest.approx([10 + way, 10 + 1.5 - way], abs=1e-5)
    assert p.z[rows] == pytest.approx([5, 5 + (1 - left) / 2])


@pytest.mark.parametrize(("edges", "size"), [("torus", [20.0, 16.0]), ("walls", [20.0, 16.0])])
def test_the_kernel_is_its_slow_twin(meadow, edges, size):
    rng = np.random.default_rng(4)
    n = 80
    rocks = [{"at": [10.0, 8.0], "radius": 4.0}]
    terrain = {
        "cell": 1.0,
        "rocks": rocks,
        "hills": {"seed": 3, "amplitude": 2.0, "scale": 8.0},
        "slope_cost": 2.0,
    }
    world = meadow(world={"space": {"size": size, "edges": edges}, "terrain": terrain}, count=n)
    x, y, heading = rng.random(n) * size[0], rng.random(n) * size[1], rng.random(n) * 6.28
    x, y, heading = (v.astype(np.float32).astype(float) for v in (x, y, heading))
    decision = rng.integers(0, 2, (n, 7))
    places = _moved(world, decision, x=x, y=y, heading=heading)
    cost = world.tables["deer"][Velocity].cost[world.tables["deer"].by_uid()]
    height = world.terrain.height

    def h(x, y):
        i, j = int(np.floor(x - 0.5)), int(np.floor(y - 0.5))
        fx, fy = x - 0.5 - i, y - 0.5 - j

        def corner(i, j):
            ny, nx = height.shape
            return float(
                height[
                    (j % ny, i % nx) if edges == "torus" else (min(max(j, 0), ny - 1), min(max(i, 0), nx - 1))
                ]
            )

        return (1 - fy) * ((1 - fx) * corner(i, j) + fx * corner(i + 1, j)) + fy * (
            (1 - fx) * corner(i, j + 1) + fx * corner(i + 1, j + 1)
        )

    for a in range(n):
        gait = next((g for g in range(3) if decision[a, g]), 0)
        turn = next((t for t in range(3) if decision[a, 3 + t]), 1)
        angle = (heading[a] + (0.5, 0, -0.5)[turn]) % (2 * np.pi)
        speed, price = (0, 1, 3)[gait], (0, 0.02, 0.1)[gait]

        def reached(way, a=a, angle=angle):
            to = [x[a] + way * np.cos(angle), y[a] + way * np.sin(angle)]
            return [
                t % s if edges == "torus" else min(max(t, 0), s - 1e-5) for t, s in zip(to, size, strict=True)
            ]

        halves = [i / 2 for i in range(2 * speed + 1)]  # half cells along the way
        blocked = next(
            (w for w in halves[1:] if world.terrain.ground[int(reached(w)[1]), int(reached(w)[0])]), None
        )
        speed = speed if blocked is None else blocked - 0.5
        to = reached(speed) if speed else [x[a], y[a]]
        if speed:
            price *= 1 + 2 * max(h(*to) - h(x[a], y[a]), 0) / speed
        assert places[a] == pytest.approx([*to, angle], abs=1e-3)
        assert cost[a] == pytest.approx(price, abs=1e-4)


def test_a_fast_animal_does_not_jump_a_thin_lake():
    space = Space((40.0, 40.0), "walls")
    terrain = Terrain(space, 1.0, lakes=[{"at": [20.0, 20.0], "radius": 1.5}])
    stopped = free_way(
        np.float32(10.0),
        np.float32(20.0),
        np.float32(0.0),
        np.float32(1.0),
        np.float32(20.0),
        np.float32(1.0),
        terrain.maps,
        space.extent,
    )
    assert 10.0 + stopped < 20.0 - 0.5
    beside = free_way(
        np.float32(10.0),
        np.float32(5.0),
        np.float32(0.0),
        np.float32(1.0),
        np.float32(20.0),
        np.float32(1.0),
        terrain.maps,
        space.extent,
    )
    assert beside == 20.0
