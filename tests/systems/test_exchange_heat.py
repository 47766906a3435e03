"""Bodies take on the temperature of their surroundings; metabolism warms them; regulation costs energy."""

import math

import numpy as np
import pytest

from ecs_eco.components import HeatExchange, Metabolism, Physical
from ecs_eco.systems import ExchangeHeat, Metabolise
from ecs_eco.systems.exchange_heat import Heat, exchange, span, when
from ecs_eco.testing import act, arrange

F = np.float32
AREA = 4 * math.pi * 0.5**2  # [m^2] of a deer: pi
# capacity 1000 J/K, conductance 2 W/(m^2 K) × pi m^2: 2 pi W/K, rate 2 pi/1000 per second
DEER = {
    "body": {"radius": 0.5, "mass": 10.0},
    "properties": {"temperature": 310.0},
    "metabolism": {"energy": 1.0, "basal": 0.0},
    "locomotion": {"speed": {"walk": 0.0, "run": 0.0}},
}
HEAT = {"specific_heat": 100.0, "conductance": 2.0}
RATE = 2.0 * AREA / 1000.0


def warmth(world, name="deer"):
    """The temperatures of a kind in the order of uids, with what float32 cannot hold of them: f64[n]."""
    table = world.tables[name]
    rows = table.by_uid()
    return table[Physical].temperature[rows].astype(float) + table[HeatExchange].residue[rows]


@pytest.fixture
def cold(meadow):
    """A function of the heat section that returns a world at 300 K with two deer of 310 K."""

    def build(heat=None, dt=1.0, world=None, **deer):
        new = meadow(
            world={"dt": dt, "ambient": {"temperature": 300.0}} | (world or {}),
            heat=HEAT | (heat or {}),
            **(DEER | deer),
        )
        arrange(new, "deer", energy=1.0)
        return new

    return build


@pytest.mark.definition("1 temperature", "3 physical rules")
def test_a_body_cools_as_newton_says(cold):
    world = cold()
    act(world, ExchangeHeat)
    assert warmth(world) == pytest.approx([300 + 10 * math.exp(-RATE)] * 2, abs=1e-9)
    assert warmth(world)[0] == pytest.approx(309.93736, abs=1e-5)  # 10 K × (1 − 0.0062635)
    for _ in range(499):
        act(world, ExchangeHeat)
    assert warmth(world) == pytest.approx([300 + 10 * math.exp(-500 * RATE)] * 2, abs=1e-6)


@pytest.mark.parametrize("dt", [0.001, 0.5, 10.0, 1e6])
def test_a_tick_of_any_length_is_exact(cold, dt):
    world = cold(dt=dt)
    act(world, ExchangeHeat)
    assert warmth(world) == pytest.approx([300 + 10 * math.exp(-RATE * dt)] * 2, abs=1e-9)


def test_two_half_ticks_are_a_whole_one_regulated_or_not(cold):
    shivers = {"set_point": 311.0, "warming": 200.0, "cost": 0.0001}  # arrives after 7.5 s, then holds
    for heat in ({}, {"metabolic_heat": 4000.0}, {"regulate": shivers}):
        whole, halves = cold(heat, dt=10.0), cold(heat, dt=5.0)
        arrange(whole, "deer", burnt=0.25)
        act(whole, ExchangeHeat)
        for _ in range(2):
            arrange(halves, "deer", burnt=0.125)
            act(halves, ExchangeHeat)
        assert warmth(halves) == pytest.approx(warmth(whole), abs=1e-8)
        one, two = (w.tables["deer"][Metabolism].energy[0] for w in (whole, halves))
        assert two == pytest.approx(one, abs=1e-7)
        assert one < 1 or "regulate" not in heat


def test_slow_changes_add_up_though_float32_cannot_hold_one(cold):
    world = cold({"specific_heat": 1e7})  # 6e-7 K in a tick; float32 has steps of 3e-5 K
    for _ in range(1000):
        act(world, ExchangeHeat)
    slow = 2.0 * AREA / 1e8
    assert warmth(world) == pytest.approx([300 + 10 * math.exp(-1000 * slow)] * 2, abs=1e-7)
    assert world.tables["deer"][Physical].temperature[0] == F(warmth(world)[0]) < 310


def test_insulation_is_in_series_with_the_bare_surface(cold):
    world = cold({"insulation": 0.5})  # 1/(1/2 + 0.5) = 1 W/(m^2 K): half of the bare one
    act(world, ExchangeHeat)
    assert warmth(world) == pytest.approx([300 + 10 * math.exp(-RATE / 2)] * 2, abs=1e-9)
    sealed = cold({"conductance": 0.0})
    act(sealed, ExchangeHeat)
    assert warmth(sealed).tolist() == [310, 310]


def test_small_bodies_cool_sooner_than_large_ones(cold):
    world = cold()
    arrange(world, "deer", radius=[0.5, 0.25], mass=[10, 1.25])  # half as long, of the same stuff
    act(world, ExchangeHeat)
    assert warmth(world) == pytest.approx([300 + 10 * math.exp(-RATE * f) for f in (1, 2)], abs=1e-9)


def test_what_is_burnt_warms_until_as_much_is_lost(cold):
    """At 2 pi W/K, 62.8 W keep a body 10 K above its surroundings: 0.0314 a second at 2000 J each."""
    world = cold(
        {"metabolic_heat": 2000.0}, metabolism={"energy": 1.0, "energy_max": 1.0, "basal": AREA / 100}
    )
    for _ in range(20):
        arrange(world, "deer", burnt=0.0)
        act(world, Metabolise)
        act(world, ExchangeHeat)
    assert warmth(world) == pytest.approx([310, 310], abs=1e-4)
    arrange(world, "deer", temperature=[300, 330], residue=0, burnt=AREA / 100)
    act(world, ExchangeHeat)
    away = 10 * math.exp(-RATE)
    assert warmth(world) == pytest.approx([310 - away, 310 + 2 * away], abs=1e-4)


def test_holding_the_set_point_costs_what_is_lost(cold):
    way = {"set_point": 310.0, "warming": 100.0, "cost": 0.001}
    world = cold({"regulate": way})
    act(world, ExchangeHeat)
    m = world.tables["deer"][Metabolism]
    assert warmth(world).tolist() == [310, 310]
    assert m.burnt[:2] == pytest.approx([20 * AREA * 0.001] * 2, rel=1e-6)  # 62.8 W for a second
    assert (m.energy[:2] + m.burnt[:2]).tolist() == [1, 1]


def test_power_is_bounded(cold):
    """30 W of the 62.8 W that are lost: it cools as if it were 30 W/(2 pi W/K) = 4.77 K warmer outside."""
    world = cold({"regulate": {"set_point": 310.0, "warming": 30.0, "cost": 0.001}})
    act(world, ExchangeHeat)
    end = 300 + 30 / (2 * AREA)
    assert warmth(world) == pytest.approx([end + (310 - end) * math.exp(-RATE)] * 2, abs=1e-9)
    assert world.tables["deer"][Metabolism].burnt[:2] == pytest.approx([0.03, 0.03])


def test_full_power_until_the_set_point_then_what_holds_it(cold):
    world = cold(
        {
            "conductance": 0.0,
            "regulate": {"set_point": 310.0, "warming": 500.0, "cooling": 250.0, "cost": 0.0001},
        },
        dt=4.0,
    )
    # 1 K is 1000 J: two seconds of warming, four of cooling; 3 K are more than a tick of cooling can take
    arrange(world, "deer", temperature=[309, 313])
    act(world, ExchangeHeat)
    assert warmth(world).tolist() == [310, 312]
    assert world.tables["deer"][Metabolism].burnt[:2] == pytest.approx([0.1, 0.1])


def test_nobody_pants_who_can_only_shiver(cold):
    world = cold({"regulate": {"set_point": 305.0, "warming": 500.0, "cost": 0.001}})
    act(world, ExchangeHeat)
    assert warmth(world) == pytest.approx([300 + 10 * math.exp(-RATE)] * 2, abs=1e-9)
    assert not world.tables["deer"][Metabolism].burnt[:2].any()


def test_who_has_no_energy_cannot_regulate(cold):
    world = cold({"conductance": 0.0, "regulate": {"set_point": 320.0, "warming": 1000.0, "cost": 0.001}})
    arrange(world, "deer", energy=[0.25, -1.0])  # 250 J: a quarter of a kelvin
    act(world, ExchangeHeat)
    m = world.tables["deer"][Metabolism]
    assert warmth(world) == pytest.approx([310.25, 310], abs=1e-6)
    assert m.energy[:2].tolist() == [0, -1]
    assert m.burnt[:2].tolist() == [0.25, 0]


@pytest.mark.definition("2 properties")
def test_objects_cool_too(meadow):
    stone = {
        "at": [[5.0, 5.0]],
        "body": {"radius": 0.5, "mass": 10.0},
        "properties": {"temperature": 310.0},
        "heat": HEAT,
    }
    world = meadow(world={"objects": {"stone": stone}, "ambient": {"temperature": 300.0}})
    act(world, ExchangeHeat)
    assert warmth(world, "stone") == pytest.approx([300 + 10 * math.exp(-RATE)], abs=1e-9)


def test_surroundings_are_those_of_the_place(cold):
    world = cold()
    arrange(world, "deer", x=[0, 10])
    world.environment["temperature"] = lambda w, x, y, z: 300 + x  # in float64, as users write it
    act(world, ExchangeHeat)
    assert warmth(world) == pytest.approx([300 + 10 * math.exp(-RATE), 310], abs=1e-9)


def test_worlds_without_heat_have_no_such_system(meadow):
    world = meadow()
    assert ExchangeHeat not in [type(system) for system in world.systems]
    assert HeatExchange not in world.tables["deer"]


def test_a_table_made_by_hand_keeps_its_temperature_until_it_is_told_how_to_exchange_heat():
    from ecs_eco import World
    from ecs_eco.components import Body, Position
    from ecs_eco.config.features.heat import Heat

    world = World((10, 10))
    table = world.add_table("pebble", Position, Body, Physical, HeatExchange)
    world.add_system(ExchangeHeat())
    world.spawn("pebble", Body(radius=0.5, mass=10.0), Physical(temperature=310.0))
    world.ambient["temperature"] = 300.0
    world.run(1)
    assert warmth(world, "pebble") == [310]
    table.species.heat = Heat(**HEAT)
    world.run(1)
    assert warmth(world, "pebble") == pytest.approx([300 + 10 * math.exp(-RATE)], abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_the_kernel_is_its_slow_twin(seed):
    """The twin takes 2,000 small Euler steps, deciding in each what to do."""
    rng = np.random.default_rng(seed)
    n, steps, dt = 40, 2000, 5.0
    alive = rng.random(n) < 0.8
    mass, radius = rng.uniform(1, 20, n).astype(F), rng.uniform(0.1, 1, n).astype(F)
    around, coat = rng.uniform(270, 320, n).astype(F), rng.uniform(0, 1, n).astype(F)
    temperature, energy = rng.uniform(300, 315, n).astype(F), rng.choice([0.01, 1.0], n).astype(F)
    burnt, residue = rng.uniform(0, 0.1, n).astype(F), np.zeros(n, F)
    now, store, own = temperature.astype(float), energy.astype(float), 500.0 * burnt.astype(float) / dt
    k = 4 * np.pi * radius.astype(float) ** 2 / (1 / 5.0 + coat)
    capacity, h = mass.astype(float) * 100, dt / steps
    for _ in range(steps):
        wanted = (310.0 - now) * capacity / h - own + k * (now - around)
        power = np.where(store > 0, wanted.clip(-60.0, 90.0), 0)
        store -= np.abs(power) * h * 1e-4
        now += (own + power - k * (now - around)) / capacity * h
    before, booked = energy.copy(), burnt.copy()
    exchange(
        0,
        n,
        alive,
        mass,
        radius,
        around,
        coat,
        Heat(100.0, 5.0, 0.3, 500.0, 310.0, 90.0, 60.0, 1e-4),
        dt,
        temperature,
        residue,
        energy,
        burnt,
    )
    assert temperature[alive] == pytest.approx(now[alive], abs=0.02)
    assert energy[alive] == pytest.approx(store[alive], abs=2e-4)
    assert burnt - booked == pytest.approx(before - energy, abs=1e-7)
    assert (energy[~alive] == before[~alive]).all()
    assert energy.min() >= -1e-9


def test_the_time_to_a_temperature_inverts_its_course():
    for rate, time, slope in ((0.0, 3.0, 2.0), (0.25, 3.0, -2.0), (1e-9, 3.0, 2.0)):
        assert when(slope * span(rate, time), slope, rate) == pytest.approx(time)
    assert when(1.0, -1.0, 0.1) == when(1.0, 0.1, 0.1) == when(1.0, 0.0, 0.1) == math.inf
