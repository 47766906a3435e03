"""Lambs: what happens to them, counted by hand; and that the world is the one of the paper's Figure 1."""

import math

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Chemistry, Nervous, Policy, Position
from ecs_eco.config import load
from ecs_eco.systems import Decide, Perish, Sense
from ecs_eco.testing import act, arrange, check_component, check_system, check_world
from ecs_eco.worlds.lamb.systems import Breathe, Burn, Sucking, Suckle, burn, inhale, suck

F = np.float32
FEW = {"species.lamb.count": 4, "species.ewe.count": 1, "objects.water.count": 1}


def meadow(**changed):
    """One ewe at (5, 5), one pool at (2, 2), four lambs at (8, 8) heading east, which decide nothing."""
    world = World.from_config(load("lamb", {**FEW, **changed}), seed=1, learn=False)
    arrange(world, "ewe", x=5, y=5)
    arrange(world, "water", x=2, y=2)
    arrange(world, "lamb", x=8, y=8, heading=0, decision=np.zeros(7, np.uint8))
    return world


def blood(world, substance):
    """The concentration of a substance in the lambs, in the order of their uids [mmol/L]."""
    lambs = world.table("lamb")
    return (1000 * lambs[Chemistry].molarity[lambs.by_uid(), world.substances.index(substance)]).tolist()


def fill(world, substance, *amounts):
    """Set the concentration of a substance [mmol/L] in the lambs, in the order of their uids."""
    lambs = world.table("lamb")
    lambs[Chemistry].molarity[lambs.by_uid(), world.substances.index(substance)] = np.array(amounts) / 1000


def decide(world, action, *who):
    """Let only some lambs, by the order of uids, do an action, of their own accord."""
    lambs = world.table("lamb")
    decision = np.zeros((lambs.n, 7), np.uint8)
    decision[list(who), lambs.species.nerves.column(action)] = 1
    arrange(world, "lamb", decision=decision)


def test_who_inhales_in_air_gets_oxygen_up_to_saturation():
    world = meadow()
    fill(world, "oxygen", 3.0, 6.5, 7.0, 3.0)
    decide(world, "inhale", 0, 1, 2)
    act(world, Breathe)
    assert blood(world, "oxygen") == pytest.approx([3.7, 7.0, 7.0, 3.0], abs=1e-5)
    assert blood(world, "water") == [0, 0, 0, 0]


def test_who_inhales_with_its_nostrils_in_water_drowns_and_who_turns_away_does_not():
    world = meadow()
    fill(world, "oxygen", 3.0, 3.0, 3.0, 3.0)
    arrange(world, "lamb", x=[1.5, 1.5, 1.5, 1.4], y=2, heading=[0, math.pi, 0, 0])  # contact is up to 0.55 m
    decide(world, "inhale", 0, 1, 3)
    act(world, Breathe)
    assert blood(world, "water") == [1000, 0, 0, 0]
    assert blood(world, "oxygen") == pytest.approx([3.0, 3.7, 3.0, 3.7], abs=1e-5)
    first = int(world.table("lamb").uid[world.table("lamb").by_uid()[0]])
    deaths = []
    world.on_death.append(
        lambda table, rows: deaths.extend((int(table.uid[r]), world.causes[table.cause[r] - 1]) for r in rows)
    )
    act(world, Perish)
    world.flush()
    assert deaths == [(first, "drowned")]


@pytest.mark.definition("3 chemical rules")
def test_milk_flows_after_four_seconds_of_sucking_without_a_pause():
    world = meadow()
    fill(world, "glucose", 2.0, 2.0, 4.99, 2.0)
    arrange(world, "lamb", x=[4.2, 4.2, 4.2, 8], y=5, heading=[0, math.pi, 0, 0])  # contact is up to 0.9 m
    decide(world, "suck", 0, 1, 2, 3)
    for _ in range(6):
        act(world, Suckle)
    assert blood(world, "glucose") == pytest.approx([2.12, 2.0, 5.0, 2.0], abs=1e-5)
    decide(world, "suck", 2)
    act(world, Suckle)
    lambs = world.table("lamb")
    assert lambs[Sucking].since[lambs.by_uid()].tolist() == [0, 0, 7, 0]
    decide(world, "suck", 0)
    for _ in range(4):
        act(world, Suckle)
    assert blood(world, "glucose")[0] == pytest.approx(2.12, abs=1e-5)
    act(world, Suckle)
    assert blood(world, "glucose")[0] == pytest.approx(2.18, abs=1e-5)


@pytest.mark.definition("3 chemical rules")
def test_let_down_takes_the_same_time_in_short_ticks():
    world = meadow(dt=0.1)
    fill(world, "glucose", 2.0, 2.0, 2.0, 2.0)
    arrange(world, "lamb", x=[4.2, 8, 8, 8], y=5, heading=0)
    decide(world, "suck", 0)
    for _ in range(40):
        act(world, Suckle)
    assert blood(world, "glucose")[0] == 2.0
    act(world, Suckle)
    assert blood(world, "glucose")[0] == pytest.approx(2.006, abs=1e-5)


@pytest.mark.definition("3 chemical rules")
def test_living_and_walking_burn_glucose_and_oxygen_by_the_second():
    world = meadow(dt=0.5)
    fill(world, "glucose", 3.0, 3.0, 0.001, 3.0)
    fill(world, "oxygen", 5.0, 5.0, 5.0, 0.05)
    arrange(world, "lamb", speed=[0, 0.2, 0, 0])
    act(world, Burn)
    assert blood(world, "glucose") == pytest.approx([2.99825, 2.99765, 0, 2.99825], abs=1e-5)
    assert blood(world, "oxygen") == pytest.approx([4.9, 4.89, 4.9, 0], abs=1e-5)


@pytest.mark.slow
def test_without_breath_a_lamb_suffocates_in_half_a_minute_and_without_milk_it_starves_in_15_minutes():
    world = meadow(
        **{"species.lamb.policy.kind": "none", "species.lamb.policy.learn": False, "species.lamb.ppo": {}}
    )
    deaths = []
    world.on_death.append(
        lambda table, rows: deaths.extend((world.causes[table.cause[r] - 1], world.tick) for r in rows)
    )
    world.run(40)
    assert deaths == [("suffocated", 32)] * 4  # (7 − 0.4) / 0.2 = 33 ticks, of which the first is tick 0

    world = meadow(
        **{
            "species.lamb.reflex.formulas": {"inhale": "1"},
            "species.lamb.policy.kind": "none",
            "species.lamb.policy.learn": False,
            "species.lamb.ppo": {},
        }
    )
    world.on_death.append(
        lambda table, rows: deaths.extend((world.causes[table.cause[r] - 1], world.tick) for r in rows)
    )
    world.run(1200)
    assert [cause for cause, _ in deaths[4:]] == ["starved"] * 4
    assert all(1140 <= tick <= 1145 for _, tick in deaths[4:])  # (5 − 1) / 0.0035 = 1143


def test_of_all_reflex_connections_two_are_not_zero():
    species = load("lamb").species["lamb"]
    network = np.zeros((len(species.channels(2)), len(species.action_list())))
    for c in species.reflex.connections:
        network[species.channels(2).index(c.sensor), species.action_rows()[c.action]] = c.weight
    assert network.shape == (7, 7)
    assert np.argwhere(network).tolist() == [[0, 1], [1, 0]]  # touch_udder → suck, touch_water → inhale
    assert (network[0, 1], network[1, 0]) == (1, -1)


@pytest.mark.parametrize(
    ("at", "suck", "inhale"), [((4.2, 5.0), [1, 1, 1, 1], None), ((1.5, 2.0), None, [0, 0, 0, 0])]
)
def test_the_reflexes_force_sucking_at_the_udder_and_forbid_inhaling_in_water(at, suck, inhale):
    world = meadow()
    lambs = arrange(world, "lamb", x=at[0], y=at[1])
    for _ in range(20):  # whatever their policies choose
        act(world, Sense)
        act(world, Decide)
        decision, rows = lambs[Nervous].decision, lambs.by_uid()
        for action, wanted in (("suck", suck), ("inhale", inhale)):
            if wanted is not None:
                assert decision[rows, lambs.species.nerves.column(action)].tolist() == wanted
        world.tick += 1


def test_what_the_systems_touch_is_what_the_sensors_feel():
    """Where inhaling drowns, touch_water is 1 and nowhere else; where sucking counts, touch_udder is."""
    world = World.from_config(
        load("lamb", {"species.lamb.count": 400, "objects.water.count": 60}), seed=2, learn=False
    )
    act(world, Sense)
    lambs = world.table("lamb")
    nerves = lambs.species.nerves
    rows = nerves.rows.copy()
    arrange(world, "lamb", decision=np.eye(7, dtype=np.uint8)[[0]] + np.eye(7, dtype=np.uint8)[[1]])
    act(world, Breathe)
    act(world, Suckle)
    drowns, counts = lambs[Chemistry].molarity[rows, 2] > 0, lambs[Sucking].since[rows] > 0
    assert drowns.tolist() == (nerves.x[:, 1] == 1).tolist()
    assert counts.tolist() == (nerves.x[:, 0] == 1).tolist()
    assert 20 < drowns.sum() < 380
    assert 20 < counts.sum() < 380


def test_the_kernels_are_their_slow_twins():
    rng = np.random.default_rng(4)
    n = 60
    rows, flags = rng.permutation(n)[:40], rng.random((2, n)) < 0.5
    touches = (rng.random(40) < 0.5).astype(F)
    before = (0.01 * rng.random((n, 3))).astype(F)

    air = before.copy()
    inhale(rows, touches, flags[0], F(0.001), F(0.007), F(1), 1, 2, air)
    slow = before.copy()
    for row, wet in zip(rows, touches, strict=True):
        if flags[0, row]:
            slow[row] += [0, 0, 1] if wet else [0, np.clip(0.007 - slow[row, 1], 0, 0.001), 0]
    assert air == pytest.approx(slow, abs=1e-7)

    milk, since = before.copy(), rng.integers(0, 6, n).astype(np.int32)
    slow, clock = before.copy(), since.copy()
    suck(rows, touches, flags[1], 4, F(0.001), F(0.005), 0, since, milk)
    for row, touch in zip(rows, touches, strict=True):
        sucks = bool(touch) and flags[1, row]
        slow[row, 0] += np.clip(0.005 - slow[row, 0], 0, 0.001) if sucks and clock[row] >= 4 else 0
        clock[row] = clock[row] + 1 if sucks else 0
    assert milk == pytest.approx(slow, abs=1e-7)
    assert since.tolist() == clock.tolist()

    left, speed = before.copy(), rng.random(n).astype(F)
    burn(flags[0], speed, F(0.002), F(0.003), 1, left)
    slow = before.copy()
    slow[flags[0], 1] = np.maximum(slow[flags[0], 1] - 0.002 - 0.003 * speed[flags[0]], 0)
    assert left == pytest.approx(slow, abs=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("system", [Breathe, Suckle, Burn])
def test_the_systems_keep_the_rules(system):
    check_system(system, lambda threads: World.from_config("lamb", threads=threads), ticks=15)


def test_the_component_and_the_world_keep_the_rules():
    check_component(Sucking)
    small = load("lamb", {"species.lamb.ppo.horizon": 8, "species.lamb.ppo.minibatch_size": 8})
    check_world(lambda threads: World.from_config(small, threads=threads), ticks=20)


def test_every_lamb_learns_for_itself():
    world = World.from_config(load("lamb", {"species.lamb.ppo.horizon": 16}), seed=1)
    lambs = world.table("lamb")
    rows = lambs.by_uid()
    before = np.array(lambs[Policy].weights[rows])
    world.run(40)
    after = np.array(lambs[Policy].weights[lambs.by_uid()])
    assert lambs.n == 24
    assert (before != after).any(axis=1).all()
    assert len(np.unique(after, axis=0)) == 24


def test_ewes_stay_and_live():
    world = World.from_config("lamb", seed=1)
    ewes = world.table("ewe")
    places = ewes[Position].x[ewes.by_uid()].copy()
    world.run(30)
    assert ewes.n == 8
    assert ewes[Position].x[ewes.by_uid()].tolist() == places.tolist()
