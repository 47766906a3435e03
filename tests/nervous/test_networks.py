import numpy as np
import pytest

from ecs_eco.components import HappinessWeights, Reflexes
from ecs_eco.nervous.networks import connect, weigh

F = np.float32


def _drawn(n=30, channels=5, seed=1):
    rng = np.random.default_rng(seed)
    readings = [(0,), (1, 3), (2, 3, 4), (4,)]
    flat = np.array([c for r in readings for c in r])
    starts = np.cumsum([0, *map(len, readings)])
    return rng, rng.random((n, channels)).astype(F), readings, flat, starts


def _weights(rng, rows, n):
    weight = rng.integers(-1, 2, (n, 4)).astype(np.int8)
    return weight, rng.random((n, 4)).astype(F), rng.permutation(n)[: len(rows)]


def test_connections_of_each_own_weights_are_their_slow_twin():
    rng, x, readings, flat, starts = _drawn()
    weight, threshold, rows = _weights(rng, x, 50)
    actions, above = np.array([0, 2, 2, 1]), np.array([True, False, True, False])
    total = np.zeros((30, 3), F)
    connect(x.T, flat, starts, actions, above, weight, threshold, rows, total)
    slow = np.zeros((30, 3))
    for i, row in enumerate(rows):
        for c, reading in enumerate(readings):
            value = x[i, list(reading)].mean()
            fires = value > threshold[row, c] if above[c] else value < threshold[row, c]
            slow[i, actions[c]] += weight[row, c] * fires
    assert np.array_equal(total, slow)
    assert len(np.unique(slow)) > 3


def test_happiness_of_each_own_weights_is_its_slow_twin():
    rng, x, readings, flat, starts = _drawn(seed=2)
    weight, rows = rng.normal(size=(50, 4)).astype(F), rng.permutation(50)[:30]
    felt = np.empty(30, F)
    weigh(x.T, flat, starts, weight, rows, felt)
    slow = [
        sum(weight[row, c] * x[i, list(r)].mean() for c, r in enumerate(readings))
        for i, row in enumerate(rows)
    ]
    assert felt == pytest.approx(np.array(slow), abs=1e-5)


def test_a_plain_function_of_the_senses_stays_a_network(meadow):
    world = meadow(count=3)
    deer = world.tables["deer"]
    nerves = deer.species.nerves
    nerves.rows, nerves.x = np.arange(3), np.array([[0.1], [0.2], [0.3]], F)
    nerves.happiness = lambda x: 2 * x[:, 0]
    nerves.reflex = lambda x: np.ones((len(x), len(nerves.actions)), np.int8)
    assert nerves.feel(deer) == pytest.approx([0.2, 0.4, 0.6])
    assert nerves.react(deer).shape == (3, len(nerves.actions))
    nerves.reflex = nerves.happiness = None
    assert nerves.feel(deer) is None
    assert nerves.react(deer) is None


def test_networks_read_the_columns_of_those_that_sense(meadow):
    genes = [
        {"name": "calm", "trait": "reflex.calm.weight", "letters": 1, "values": [-1, -1, 1, 1]},
        {"name": "joy", "trait": "happiness.energy", "letters": 1, "values": [1, 2, 3, 4]},
    ]
    world = meadow(
        count=40,
        genome={"genes": genes},
        happiness={"weights": {"energy": 1.0}, "minimum": -1.0, "formula": None},
        reflex={
            "connections": [{"name": "calm", "sensor": "energy", "action": "run", "weight": 0, "above": 0.0}]
        },
    )
    deer = world.tables["deer"]
    nerves, rows = deer.species.nerves, deer.rows()[::-3]
    nerves.rows, nerves.x = rows, np.full((rows.size, 1), 0.5, F)
    assert nerves.react(deer)[:, nerves.column("run")].tolist() == deer[Reflexes].weight[rows, 0].tolist()
    assert nerves.feel(deer) == pytest.approx(0.5 * deer[HappinessWeights].weight[rows, 0])
    assert len(np.unique(deer[HappinessWeights].weight[deer.rows(), 0])) == 4
