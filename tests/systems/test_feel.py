import numpy as np
import pytest

from ecs_eco.components import Nervous
from ecs_eco.nervous.formula_steps import AS_READ
from ecs_eco.systems import Feel, Perish, Sense
from ecs_eco.systems.feel import feel
from ecs_eco.testing import act, arrange

F = np.float32


def _live(world, energy):
    table = arrange(world, "deer", energy=energy)
    act(world, Sense)
    act(world, Feel)
    n = table[Nervous]
    return n.happiness[:2].tolist(), n.reward[:2].tolist()


@pytest.mark.definition("3 happiness", "5 reward")
def test_the_reward_is_the_change_of_happiness_and_a_newborn_has_none(meadow):
    world = meadow(happiness={"formula": "2 * energy"})
    assert not world.tables["deer"][Nervous].awake[:2].any()
    assert _live(world, [0.25, 0.5]) == ([0.5, 1.0], [0, 0])
    assert _live(world, [0.5, 0.375]) == ([1.0, 0.75], [0.5, -0.25])
    assert _live(world, [0.5, 0.375]) == ([1.0, 0.75], [0, 0])


def test_rewards_add_up_to_the_happiness_gained(meadow):
    world = meadow(happiness={"formula": "energy * energy"})
    first, _ = _live(world, [0.1, 0.2])
    total = np.zeros(2)
    for energy in np.random.default_rng(0).random((20, 2)):
        last, reward = _live(world, energy)
        total += reward
    assert total == pytest.approx(np.subtract(last, first), abs=1e-5)


def test_happiness_of_the_dead_is_the_minimum(meadow):
    world = meadow(happiness={"formula": "energy", "minimum": -3.0})
    deer = arrange(world, "deer", energy=[0.5, 0.25])
    act(world, Sense)
    act(world, Feel)
    arrange(world, "deer", energy=[0.0, 0.25])  # one starves
    last = []
    world.on_death.append(
        lambda table, rows: last.append((table.uid[rows].tolist(), table[Nervous].reward[rows].tolist()))
    )
    act(world, Perish)
    world.flush()
    assert last == [([int(deer.uid.max()) - 1], [-3.5])]


def test_one_born_into_the_row_of_a_dead_one_inherits_no_feelings(meadow):
    world = meadow()
    _live(world, [0.5, 0.75])
    world.kill(int(world.tables["deer"].uid[1]))
    world.flush()
    world.spawn("deer")
    world.flush()
    n = world.tables["deer"][Nervous]
    assert (n.happiness[1], n.reward[1], n.awake[1]) == (0, 0, False)
    assert _live(world, [0.25, 0.75]) == ([0.25, 0.75], [-0.25, 0])


def test_without_a_happiness_network_nothing_is_felt(meadow):
    world = meadow(happiness=None)
    assert _live(world, [0.5, 0.75]) == ([0, 0], [0, 0])
    world.run(2)


def test_the_kernel_is_its_slow_twin():
    rng = np.random.default_rng(1)
    n, capacity = 30, 50
    rows = rng.permutation(capacity)[:n]
    now, happiness, reward = (rng.random(k).astype(F) for k in (n, capacity, capacity))
    awake = rng.random(capacity) < 0.5
    before, slept = happiness.copy(), ~awake
    old_reward = reward.copy()
    feel(0, n, rows, now[None], *AS_READ, F(0.3), happiness, reward, awake)
    now = np.maximum(now, F(0.3))
    expected = np.where(slept[rows], 0, now - before[rows])
    assert reward[rows] == pytest.approx(expected)
    assert (happiness[rows] == now).all()
    assert awake[rows].all()
    rest = np.setdiff1d(np.arange(capacity), rows)
    assert (happiness[rest] == before[rest]).all()
    assert (reward[rest] == old_reward[rest]).all()
    assert (awake[rest] != slept[rest]).all()
