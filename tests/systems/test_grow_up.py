"""Growth from newborn to adult size: hand-counted courses, costs, needs, genes, refusals."""

import math

import numpy as np
import pytest

from ecs_eco.components import Body, Metabolism, Nervous, Position, Stature, Velocity
from ecs_eco.engine.errors import ConfigError
from ecs_eco.record.ledger import LEDGER, imbalance
from ecs_eco.systems import Feed, Grow, GrowUp, Metabolise, Move, Nurse, Reproduce
from ecs_eco.systems.grow_up import Law, grow_up
from ecs_eco.testing import act, arrange, check_system

F = np.float32
# an adult of 8 kg and 1 m; the cube root of a mass of 1 kg is half of the adult's
DEER = {
    "body": {"radius": 1.0, "mass": 8.0, "opaque": False},
    "growth": {"rate": 0.1, "newborn": 0.125},
    "metabolism": {"energy": 0.5, "energy_max": 10.0, "basal": 0.01},
}
BIRTHS = {"kind": "asexual", "rate": 100.0, "energy_min": 0.1, "energy_given": 0.05, "dispersal": 5.0}


def body(world):
    """Mass [kg] and radius [m] of the deer in the order of uids, and their energy."""
    deer = world.tables["deer"]
    rows = deer.by_uid()
    return tuple(c[rows].astype(float) for c in (deer[Body].mass, deer[Body].radius, deer[Metabolism].energy))


@pytest.mark.definition("3 biological rules", "1 mass")
def test_the_cube_root_of_the_mass_approaches_that_of_the_adult(meadow):
    world = meadow(**DEER)
    arrange(world, "deer", mass=[1.0, 8.0], radius=[0.5, 1.0])
    for tick in range(1, 21):
        act(world, GrowUp)
        mass, radius, _ = body(world)
        assert mass == pytest.approx([8 * (1 - 0.5 * math.exp(-0.1 * tick)) ** 3, 8], rel=1e-6)
        assert radius == pytest.approx([1 - 0.5 * math.exp(-0.1 * tick), 1], rel=1e-6)
    assert mass[0] == pytest.approx(6.4830, abs=1e-3)  # (1 − 0.5 e^−2)³ = 0.8104


def test_by_west_the_fourth_root_does(meadow):
    world = meadow(**DEER | {"growth": {"law": "west", "rate": 0.1}})
    arrange(world, "deer", mass=[0.5, 8.0])  # a sixteenth: its fourth root is half of the adult's
    for _ in range(10):
        act(world, GrowUp)
    assert body(world)[0] == pytest.approx([8 * (1 - 0.5 * math.exp(-1)) ** 4, 8], rel=1e-6)


def test_west_solves_his_own_equation():
    """dm/dt = a m^(3/4) (1 − (m/M)^(1/4)), with a = 4 k M^(1/4), in small steps."""
    m, most, k = 0.5, 8.0, 0.1
    for _ in range(100_000):
        m += 1e-4 * 4 * k * most**0.25 * m**0.75 * (1 - (m / most) ** 0.25)
    assert m == pytest.approx(8 * (1 - 0.5 * math.exp(-1)) ** 4, rel=1e-4)


def test_slow_growth_adds_up_though_float32_cannot_hold_a_step(meadow):
    world = meadow(**DEER | {"growth": {"rate": 1e-9}})
    arrange(world, "deer", mass=[1.0, 8.0], radius=[0.5, 1.0])
    for _ in range(100):
        act(world, GrowUp)
    deer = world.tables["deer"]
    row = deer.by_uid()[0]
    grown = deer[Body].mass[row].astype(float) + deer[Stature].residue[row] - 1
    assert grown == pytest.approx(24 * 0.25 * 0.5 * 1e-7, rel=1e-4)  # 3 M r² (1 − r) k t


def test_each_kilogram_costs_what_is_held_beyond_the_reserve(meadow):
    world = meadow(**DEER | {"growth": {"rate": 0.1, "cost": 0.5, "reserve": 0.3}})
    arrange(world, "deer", mass=1.0, radius=0.5, energy=[1.0, 0.4])
    wanted = 8 * (1 - 0.5 * math.exp(-0.1)) ** 3 - 1  # 0.313 kg
    act(world, GrowUp)
    mass, _, energy = body(world)
    assert mass == pytest.approx([1 + wanted, 1.2], rel=1e-6)  # 0.1 buys 0.2 kg
    assert energy == pytest.approx([1 - wanted / 2, 0.3], rel=1e-6)
    burnt = world.tables["deer"][Metabolism].burnt
    assert burnt[world.tables["deer"].by_uid()] == pytest.approx([wanted / 2, 0.1], rel=1e-5)
    act(world, GrowUp)
    assert body(world)[0][1] == pytest.approx(1.2)  # nothing left, no growth
    arrange(world, "deer", energy=5.0)
    act(world, GrowUp)
    assert body(world)[0][1] == pytest.approx(8 * (1 - (1 - 0.15 ** (1 / 3)) * math.exp(-0.1)) ** 3, rel=1e-6)


def test_the_needs_follow_the_mass(meadow):
    world = meadow(**DEER)
    arrange(world, "deer", mass=[0.5, 8.0], energy=1.0)
    act(world, Metabolise)
    assert body(world)[2] == pytest.approx([1 - 0.01 / 8, 1 - 0.01])  # 16^(3/4) = 8


def test_the_small_are_slower_where_that_is_declared(meadow):
    for pace, speeds in (0.0, [1.0, 1.0]), (0.25, [0.5, 1.0]):
        world = meadow(**DEER | {"growth": {"rate": 0.1, "pace": pace}})
        arrange(world, "deer", mass=[0.5, 8.0], x=5.0, heading=0.0, decision=[[0, 1, 0, 0, 1, 0, 0]])
        act(world, Move)
        deer = world.tables["deer"]
        rows = deer.by_uid()
        assert deer[Position].x[rows] - 5 == pytest.approx(speeds, rel=1e-6)
        assert deer[Velocity].cost[rows] == pytest.approx([0.02 * v * v for v in speeds], rel=1e-6)


def test_newborn_are_small_and_founders_are_grown(meadow):
    world = meadow(reproduction=BIRTHS, world={"dt": 0.01}, **DEER)
    assert body(world)[0].tolist() == [8, 8]
    arrange(world, "deer", x=[5, 15], y=5)
    for _ in range(9):
        act(world, Reproduce)
        world.tick += 1
    world.flush()
    mass, radius, _ = body(world)
    assert len(mass) > 2
    assert mass[2:] == pytest.approx(1.0)
    assert radius[2:] == pytest.approx(0.5)


def gene(name, trait, low, high):
    return {"name": name, "trait": trait, "letters": 5, "low": low, "high": high}


def test_the_size_of_the_adult_may_be_a_gene(meadow):
    genome = {"genes": [gene("mass", "body.mass", 4.0, 16.0), gene("size", "body.radius", 0.5, 1.0)]}
    world = meadow(count=20, reproduction=BIRTHS, world={"dt": 0.01}, genome=genome, **DEER)
    deer = world.tables["deer"]
    assert len(set(deer[Stature].mass[:20])) > 5
    assert (deer[Body].mass[:20] == deer[Stature].mass[:20]).all()
    for _ in range(5):
        act(world, Reproduce)
        world.tick += 1
    world.flush()
    young = deer.by_uid()[20:]
    assert young.size
    assert deer[Body].mass[young] == pytest.approx(deer[Stature].mass[young] * 0.125)
    assert deer[Body].radius[young] == pytest.approx(deer[Stature].radius[young] * 0.5)


def test_plants_grow_from_seedlings(meadow):
    spread = {"kind": "spread", "rate": 0.0, "seed_rain": 1.0, "spacing": 2.0}
    world = meadow(grass={"reproduction": spread, "growth": {"rate": 0.05, "newborn": 0.001}})
    world.run(1)
    grass = world.tables["grass"]
    assert grass.n > 10
    assert grass[Body].mass[grass.by_uid()[2:]] == pytest.approx(0.001)
    first = grass.by_uid()[2]
    world.run(5)
    assert grass[Body].mass[first] > 0.01


def test_the_ledger_of_energy_closes(meadow):
    way = {"rate": 0.1, "newborn": 0.125, "cost": 0.01, "reserve": 0.02}
    world = meadow(reproduction=BIRTHS | {"rate": 0.3}, **DEER | {"growth": way, "count": 5}).run(20)
    assert (world.tables["deer"][Body].mass[world.tables["deer"].rows()] < 8).any()
    page = {name: np.array(world.series()[name].to_pylist()) for name in LEDGER}
    assert np.abs(imbalance(page)).max() < 1e-6


def plain(mass, most, root, step, cost, reserve, energy):
    gain = most * (1 - (1 - (mass / most) ** root) * math.exp(-step)) ** (1 / root) - mass
    return mass + (min(gain, max(energy - reserve, 0) / cost) if cost else gain)


@pytest.mark.parametrize("cost", [0.0, 0.2])
def test_the_kernel_does_what_plain_python_does(cost):
    generator = np.random.Generator(np.random.Philox(9))
    n = 100
    alive = generator.random(n) < 0.8
    adult, energy = generator.uniform(1, 9, n).astype(F), generator.random(n).astype(F)
    mass = (adult * generator.uniform(0.01, 1, n)).astype(F)
    before, held, radius = mass.copy(), energy.copy(), np.ones(n, F)
    burnt, residue = np.zeros(n, F), np.zeros(n, F)
    law = Law(1 / 3, 0.3, 0.0, cost, 0.1)
    grow_up(0, n, alive, adult, np.ones(n, F), law, mass, radius, residue, energy, burnt)
    wanted = [
        plain(float(m), float(a), 1 / 3, 0.3, cost, 0.1, float(e)) if lives else m
        for m, a, e, lives in zip(before, adult, held, alive, strict=True)
    ]
    assert mass == pytest.approx(wanted, rel=1e-6)
    assert energy + burnt == pytest.approx(held, abs=1e-6)
    assert held - energy == pytest.approx((mass - before) * cost, abs=1e-6)


def test_the_system_keeps_the_rules(meadow):
    check_system(
        GrowUp,
        lambda threads: meadow(
            count=30,
            reproduction=BIRTHS | {"rate": 0.3},
            options={"threads": threads},
            **DEER | {"growth": {"rate": 0.1, "cost": 0.1, "pace": 0.2}},
        ),
    )


def test_a_world_in_which_nobody_grows_has_neither_system_nor_column(meadow):
    world = meadow()
    assert Stature not in world.tables["deer"]
    assert not any(isinstance(s, GrowUp) for s in world.systems)
    assert "growth" not in world.config.resolved()["species"]["deer"]


@pytest.mark.parametrize(
    ("growth", "place"),
    [
        ({"rate": 0.0}, "growth.rate = 0"),
        ({"rate": 1.0, "newborn": 2.0}, "growth.newborn = 2"),
        ({"rate": 1.0, "law": "brody"}, 'growth.law = "brody"'),
        ({}, "growth.rate"),
        ({"rate": 1.0, "cost": 1.0, "reserve": 10.0}, "growth.reserve = 10"),
    ],
)
def test_wrong_values_are_refused_by_name(meadow, growth, place):
    with pytest.raises(ConfigError) as error:
        meadow(**DEER | {"growth": growth})
    assert place in str(error.value)


def test_where_asked_the_young_hold_as_much_energy_as_their_bodies_have_room_for(meadow):
    deer = DEER | {"diet": [{"eats": "grass", "gain": 8.0, "reach": 9.0}]}
    # half of the mass: 10, 5 or 2.5 at most; what is there beyond stays, and nothing is added
    for store, before, full in ((0.0, 0.5, 8.5), (1.0, 0.5, 5.0), (2.0, 0.5, 2.5), (2.0, 3.0, 3.0)):
        world = meadow(**deer | {"growth": DEER["growth"] | {"store": store}})
        table = arrange(world, "deer", x=[2, 12], y=5.0, mass=[4.0, 8.0], energy=[before, 0.5])
        table[Nervous].decision[:] = 1
        arrange(world, "grass", x=[2, 12], y=5.0)
        act(world, Feed)
        assert body(world)[2] == pytest.approx([full, 8.5])
        assert table[Metabolism].taken[table.by_uid()] == pytest.approx([full - before, 8.0])


def test_plants_and_the_fed_are_full_as_soon_as_their_bodies_are(meadow):
    growth = DEER["growth"] | {"store": 1.0}
    world = meadow(
        **DEER | {"growth": growth, "care": {"rate": 4.0, "age_max": 9.0, "reach": 1.0}},
        grass={
            "growth": growth,
            "body": {"radius": 0.2, "mass": 8.0},
            "metabolism": {"energy": 0.5, "energy_max": 1.0, "photosynthesis": 0.4},
        },
    )
    deer = world.tables["deer"]
    uid = deer.uid[deer.by_uid()]
    arrange(world, "deer", x=5.0, y=5.0, age=[20, 1], mother=[0, uid[0]], mass=[8, 1], energy=[9, 1.0])
    act(world, Nurse)
    assert body(world)[2] == pytest.approx([9 - 0.25, 1.25])  # an eighth of 10
    arrange(world, "grass", mass=[8.0, 4.0], energy=[0.5, 0.25])
    act(world, Grow)
    grass = world.tables["grass"]
    assert grass[Metabolism].energy[grass.by_uid()] == pytest.approx([0.9, 0.5])
