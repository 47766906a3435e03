"""Wander: undecided animals walk a correlated random walk."""

import math

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.systems import Wander
from ecs_eco.systems.wander import normal
from ecs_eco.testing import check_system

N, SPEED, TURN = 3000, 0.5, 0.8


def config(dt=1.0, walker=None, **world):
    snail = {
        "count": N,
        "body": {"radius": 0.1},
        "locomotion": {"speed": {"rest": 0.0, "walk": SPEED}},
        "wander": {"turn": TURN, "gait": "walk"},
    }
    return {
        "format": 1,
        "name": "garden",
        "dt": dt,
        "space": {"size": [1000.0, 1000.0]},
        "species": {"snail": snail | (walker or {})},
    } | world


def squares(dt, ticks):
    """Return the squares of displacements after some ticks [m^2], of all in the middle at first."""
    world = World.from_config(config(dt), seed=1, record=False)
    p, rows = world.table("snail")[Position], world.table("snail").rows()
    p.x[rows], p.y[rows] = 500.0, 500.0
    world._touch()
    world.run(ticks)
    p = world.table("snail")[Position]
    return (p.x[rows].astype(float) - 500) ** 2 + (p.y[rows].astype(float) - 500) ** 2


@pytest.mark.parametrize(("dt", "ticks"), [(1.0, 20), (0.25, 80)])
def test_the_mean_squared_displacement_is_that_of_a_correlated_random_walk(dt, ticks):
    found = squares(dt, ticks)
    c = math.exp(-(TURN**2) * dt / 2)  # mean cosine of the turn in a tick
    n, step = ticks, SPEED * dt
    expected = step**2 * (n * (1 + c) / (1 - c) - 2 * c * (1 - c**n) / (1 - c) ** 2)
    error = found.std() / math.sqrt(N)
    assert abs(found.mean() - expected) < 3 * error
    tau = 2 / TURN**2  # the limit of short ticks: a persistent random walk (Fürth 1920)
    time = n * dt
    limit = 2 * (SPEED * tau) ** 2 * (time / tau - 1 + math.exp(-time / tau))
    assert expected == pytest.approx(limit, rel=0.02)


def test_changes_of_heading_are_normal_with_a_variance_that_grows_with_time():
    world = World.from_config(config(0.25), record=False)
    p, rows = world.table("snail")[Position], world.table("snail").rows()
    before = p.heading[rows].astype(float)
    world.run(4)  # a second
    change = np.remainder(world.table("snail")[Position].heading[rows] - before + np.pi, 2 * np.pi) - np.pi
    assert change.mean() == pytest.approx(0, abs=3 * TURN / math.sqrt(N))
    assert change.std() == pytest.approx(TURN, rel=0.05)
    drawn = normal(np.uint64(7), np.arange(1, 100_001, dtype=np.uint64)).astype(float)
    assert [drawn.mean(), drawn.std(), (drawn**4).mean()] == pytest.approx([0, 1, 3], abs=0.1)


def test_results_depend_on_neither_rows_nor_threads():
    small = config(walker={"count": 40})
    check_system(Wander, lambda threads: World.from_config(small, threads=threads))


def test_those_that_turn_do_not_wander():
    walker = {
        "actions": {"turn": ["left", "none"]},
        "sensors": [{"kind": "own", "property": "energy"}],
        "metabolism": {"energy": 0.5, "energy_spread": 0.5},
        "reflex": {"formulas": {"left": "1 if energy > 0.5 else -1"}},
    }
    walker["locomotion"] = {"speed": {"rest": 0.0, "walk": SPEED}, "turn": 0.25}
    world = World.from_config(config(walker=walker), record=False)
    table = world.table("snail")
    rows = table.rows()
    before = table[Position].heading[rows].copy()
    world.run(1)
    change = np.remainder(table[Position].heading[rows] - before, np.float32(2 * np.pi))
    turned = table.species.nerves.doing(table, "left")[rows]
    assert 0 < turned.sum() < N
    assert change[turned] == pytest.approx(0.25, abs=1e-5)
    assert (np.abs(change[~turned] - 0.25) < 1e-5).mean() < 0.01


def test_the_gait_is_neutral_beside_others_and_each_may_have_its_own_turn():
    gene = {"name": "g", "trait": "wander.turn", "letters": 1, "values": [0.0, 2.0]}
    walker = {"actions": {"speed": ["rest", "walk"]}, "genome": {"alphabet": "01", "genes": [gene]}}
    species = load(config(walker=walker)).species["snail"]
    assert (species.default_action, species.always_on) == ({"speed": "walk"}, [])
    world = World.from_config(config(walker=walker), record=False)
    table = world.table("snail")
    before = table[Position].heading[table.rows()].copy()
    world.run(1)
    same = np.isclose(table[Position].heading[table.rows()], before, atol=1e-6)
    assert 0.4 < same.mean() < 0.6
    assert (table[Position].x[table.rows()] != 0).all()


def test_the_resolved_world_loads_as_the_same_world():
    for walker in ({}, {"actions": {"speed": ["rest", "walk"]}}):
        walks = load(config(walker=walker))
        assert load(walks.resolved()).resolved() == walks.resolved()


@pytest.mark.parametrize(
    ("walker", "words"),
    [
        ({"wander": {"turn": 1.0, "gait": "wlak"}}, ["wander.gait", '"wlak"', 'did you mean "walk"?']),
        ({"wander": {"turn": 1.0}}, ["wander.gait", "is missing", "rest, walk"]),
        ({"locomotion": None}, ["locomotion", "is missing, but it wanders"]),
        ({"actions": {"turn": {"continuous": [-1.0, 1.0]}}}, ["actions.turn is continuous"]),
        ({"wander": {"turn": -1.0, "gait": "walk"}}, ["wander.turn = -1", "at least 0"]),
    ],
)
def test_walks_that_cannot_be_are_refused(walker, words):
    with pytest.raises(ConfigError) as error:
        load(config(walker=walker))
    for word in words:
        assert word in str(error.value)


def test_a_shipped_world_without_the_key_has_no_such_system():
    assert not any(isinstance(s, Wander) for s in World.from_config("predator-prey", record=False).systems)
