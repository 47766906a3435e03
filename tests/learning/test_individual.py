from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from ecs_eco.components import Experience, Policy
from ecs_eco.engine.random import mix_int
from ecs_eco.engine.table import Table
from ecs_eco.learning import PPO, Individuals, choose

GROUPS = (3, 2)


def whole(kernel, n, *arguments, work=None):
    kernel(0, n, *arguments)


def in_pieces(kernel, n, *arguments, work=None):
    """Three pieces on two threads."""
    bounds = [n * i // 3 for i in range(4)]
    with ThreadPoolExecutor(2) as pool:
        for done in [pool.submit(kernel, a, b, *arguments) for a, b in zip(bounds, bounds[1:], strict=False)]:
            done.result()


def minds(hidden=(6, 4), n_observations=5, seed=7, **ppo):
    return Individuals(
        n_observations, GROUPS, hidden, PPO(**{"horizon": 8, "learning_rate": 0.01} | ppo), seed
    )


def herd(individuals, n, first_uid=1, below=0):
    """A table with n newborn, the first of them in row `below`."""
    table = Table("goat", (Policy, Experience), dims=individuals.dims)
    strangers = table.occupy(below, 10**6, 0, {})
    born(table, individuals, n, first_uid, 0)
    table.vacate(strangers)
    return table


def born(table, individuals, n, first_uid, tick):
    uid = np.arange(first_uid, first_uid + n, dtype=np.uint64)
    return table.occupy(n, first_uid, tick, {(Policy, "weights"): individuals.draw(uid, 99)})


def of(uid, tick, shape, dtype=np.float32):
    """Noise that depends on the animal and the tick only, f32[n, *shape]."""
    return np.array([np.random.default_rng([int(u), tick]).random(shape, dtype) for u in uid], dtype).reshape(
        len(uid), *shape
    )


def live(table, individuals, tick, split=whole, rates=None):
    """One tick of all the living, in order of uid; return how many learnt."""
    rows = table.by_uid()
    uid = table.uid[rows]
    x, policy, experience = (
        of(uid, tick, (individuals.n_observations,)) - np.float32(0.5),
        table[Policy],
        table[Experience],
    )
    individuals.credit(experience, rows, x[:, 0])
    due = np.flatnonzero(individuals.due(experience, rows, uid, table.born[rows], tick))
    if due.size:
        rates = rates or (
            lambda uid: np.float32(0.01) + np.float32(0.001) * (uid % np.uint64(5)).astype(np.float32)
        )
        kind = (uid[due] % np.uint64(7)).astype(np.float32)
        plasticity = rates(uid[due]), np.float32(0.9) + kind / 100, kind / 50
        _, values = individuals.forward(policy, rows[due], x[due], split)
        individuals.learn(policy, experience, rows[due], uid[due], values, plasticity, split)
    logits, values = individuals.forward(policy, rows, x, split)
    choice, log_probability = np.empty((len(rows), len(GROUPS)), np.int16), np.empty(len(rows), np.float32)
    choose(logits, individuals.offsets, of(uid, tick + 10**6, (len(GROUPS),)), choice, log_probability)
    individuals.store(experience, rows, x, choice, log_probability, values)
    return due.size


def bits(table, uids=None):
    """All that the animals have learnt, by uid."""
    rows = table.by_uid()
    rows = rows if uids is None else rows[np.isin(table.uid[rows], uids)]
    policy = table[Policy]
    heavy = (policy.weights, policy.moment_1, policy.moment_2)
    return (
        b"".join(column[rows].tobytes() for column in heavy)
        + policy.steps[rows].tobytes()
        + table[Experience].length[rows].tobytes()
    )


# --- networks -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("hidden", [(), (6,), (6, 4), (9, 5, 4)])
def test_each_animal_thinks_with_its_own_network(hidden):
    individuals = minds(hidden)
    table = herd(individuals, 300)
    rows, x = table.by_uid(), np.random.default_rng(0).standard_normal((300, 5), np.float32)
    logits, values = individuals.forward(table[Policy], rows, x, whole)
    for i in (0, 7, 255, 256, 299):
        h, parts = x[i].astype(float), individuals.views(table[Policy].weights[int(rows[i])])
        for level in range(len(hidden)):
            h = np.tanh(h @ parts[2 * level] + parts[2 * level + 1])
        out = h @ parts[-2] + parts[-1]
        np.testing.assert_allclose(np.append(logits[i], values[i]), out, rtol=1e-5, atol=1e-6)


def test_shapes_and_sizes_are_those_of_the_layers_in_order():
    individuals = minds((6, 4))
    assert individuals.shapes == [(5, 6), (6,), (6, 4), (4,), (4, 6), (6,)]  # 3 + 2 logits and a value
    assert individuals.size == 30 + 6 + 24 + 4 + 24 + 6
    assert individuals.dims == {"weights": 94, "horizon": 8, "channels": 5, "groups": 2}
    assert [v.shape for v in individuals.views(np.zeros((2, 94)))] == [
        (2, *shape) for shape in individuals.shapes
    ]
    assert individuals.views(np.arange(94))[1].tolist() == [30, 31, 32, 33, 34, 35]


def test_newborn_weights_have_the_deviations_that_they_should():
    individuals = Individuals(24, (8,), (32,), PPO(), 0)
    w1, b1, w2, b2 = individuals.views(individuals.draw(np.arange(1, 501, dtype=np.uint64), 3))
    assert not b1.any()
    assert not b2.any()
    np.testing.assert_allclose(
        [w1.std(), w2[..., :8].std(), w2[..., 8].std()],
        [(2 / 24) ** 0.5, 0.01 / 32**0.5, 1 / 32**0.5],
        rtol=0.03,
    )
    assert abs(w1.mean()) < 0.002
    assert abs(np.mean(np.abs(w1) < 0.6745 * w1.std()) - 0.5) < 0.01  # half of a normal distribution


def test_a_newborn_network_depends_on_who_and_key_only():
    individuals = minds()
    both = individuals.draw(np.array([5, 9], np.uint64), 3)
    assert np.array_equal(individuals.draw(np.array([9], np.uint64), 3)[0], both[1])
    assert not np.array_equal(both[0], both[1])
    assert not np.array_equal(individuals.draw(np.array([9], np.uint64), 4)[0], both[1])


def test_observations_of_another_width_are_refused():
    individuals = minds()
    table = herd(individuals, 2)
    with pytest.raises(ValueError, match=r"\(2, 4\); expected \(2, 5\)"):
        individuals.forward(table[Policy], table.by_uid(), np.zeros((2, 4), np.float32), whole)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [((0, (2,), ()), "n_observations"), ((1, (), ()), "groups"), ((1, (2,), (4, 0)), "hidden")],
)
def test_impossible_networks_are_refused(arguments, name):
    with pytest.raises(ValueError, match=f"{name} = .*expected"):
        Individuals(*arguments, PPO(), 0)


# --- rollouts -----------------------------------------------------------------------------------------------


def test_a_reward_goes_to_the_last_transition_and_a_newborn_is_passed_over():
    individuals = minds()
    table = herd(individuals, 3)
    rows, experience = table.by_uid(), table[Experience]
    for tick in range(2):
        x, values = np.full((2, 5), tick, np.float32), np.array([10, 20], np.float32) + tick
        individuals.store(experience, rows[:2], x, np.full((2, 2), tick, np.int16), values / 100, values)
    individuals.credit(experience, rows, np.array([1, 2, 4], np.float32))
    individuals.credit(experience, rows[1:], np.array([0.5, 8], np.float32))
    assert experience.length[rows].tolist() == [2, 2, 0]
    assert experience.reward[rows][:, :3].tolist() == [[0, 1, 0], [0, 2.5, 0], [0, 0, 0]]
    assert experience.value[rows][:2, :2].tolist() == [[10, 11], [20, 21]]
    assert experience.observations[1][:2].tolist() == [[0] * 5, [1] * 5]
    assert experience.choices[1][:2].tolist() == [[0, 0], [1, 1]]
    assert experience.log_probability[1][0] == np.float32(0.2)


def test_a_full_rollout_takes_nothing_more():
    individuals = minds(horizon=2)
    table = herd(individuals, 3)
    rows = table.by_uid()
    transition = (
        np.ones((3, 5), np.float32),
        np.zeros((3, 2), np.int16),
        np.zeros(3, np.float32),
        np.zeros(3, np.float32),
    )
    for _ in range(2):
        individuals.store(table[Experience], rows, *transition)
    before = [column.copy() for column in (table[Experience].observations, table[Experience].length)]
    with pytest.raises(ValueError, match="3 of 3 rollouts already have 2 transitions"):
        individuals.store(table[Experience], rows, *(2 * part for part in transition))
    assert np.array_equal(before[0], table[Experience].observations.copy())
    assert np.array_equal(before[1], table[Experience].length)


def test_a_thirty_second_of_the_population_learns_each_tick_though_all_were_born_in_one():
    individuals = minds((), horizon=32)
    n, lengths, learnt = 1000, [], []
    table = Table("goat", (Policy, Experience), dims=individuals.dims)
    rows = table.occupy(n, 1, 0, {})
    experience, length = table[Experience], table[Experience].length
    for tick in range(128):
        due = individuals.due(experience, rows, table.uid[rows], table.born[rows], tick)
        learnt.append(int(due.sum()))
        lengths.append(np.where(due, length[rows], 0))
        length[rows[due]] = 0
        length[rows] += 1
    assert learnt[0] == 0  # nobody has lived through anything
    assert 12 <= min(learnt[1:]) <= max(learnt) <= 60  # 31 on average
    for i, uid in enumerate(table.uid[rows].tolist()):
        of_one = [t[i] for t in lengths if t[i]]
        assert of_one[0] == (mix_int(uid) % 32 or 32)
        assert set(of_one[1:]) == {32}


# --- nothing leaks ------------------------------------------------------------------------------------------


def test_what_one_animal_lives_through_changes_no_other():
    herds = []
    for odd in (False, True):
        individuals = minds(minibatch_size=3)
        table = herd(individuals, 20)
        for tick in range(20):
            if odd:  # animal 4 is another from birth on, sees other things and has other rewards
                row = int(table.by_uid()[3])
                table[Policy].weights[row] = table[Policy].weights[row] + np.float32(0.1)
                table[Experience].observations[row][:] += 1
                table[Experience].reward[row][:] -= 3
            live(table, individuals, tick)
        herds.append(table)
    others = [u for u in range(1, 21) if u != 4]
    assert bits(herds[0], others) == bits(herds[1], others)
    assert bits(herds[0], [4]) != bits(herds[1], [4])


@pytest.mark.slow
@pytest.mark.parametrize("minibatch", [3, 8192])
def test_lives_depend_neither_on_rows_nor_on_threads(minibatch):
    """Births and deaths in mid-rollout, in two blocks of rows."""
    ends = []
    for split, below in ((whole, 0), (in_pieces, 0), (whole, 40)):
        individuals = minds(minibatch_size=minibatch)
        table, learnt = herd(individuals, 250, below=below), 0
        for tick in range(30):
            learnt += live(table, individuals, tick, split)
            rows = table.by_uid()
            table.vacate(rows[of(table.uid[rows], tick, ()) < 0.05])
            born(table, individuals, 14, 1000 + 14 * tick, tick)
        ends.append((bits(table), learnt, table.high))
    assert ends[0][:2] == ends[1][:2] == ends[2][:2]
    assert ends[0][1] > 500
    assert ends[0][2] > 256


def test_who_takes_the_row_of_a_dead_learns_nothing_from_its_life():
    individuals = minds()
    taken, fresh = (
        herd(individuals, 1, first_uid=3),
        Table("goat", (Policy, Experience), dims=individuals.dims),
    )
    for tick in range(3):
        live(taken, individuals, tick)
    taken.vacate(taken.rows())
    for table in (taken, fresh):
        assert born(table, individuals, 1, 5, 3).tolist() == [0]
    assert taken[Experience].length[0] == 0
    learnt = [sum(live(table, individuals, tick) for tick in range(4, 24)) for table in (taken, fresh)]
    assert learnt[0] == learnt[1] >= 2
    assert bits(taken) == bits(fresh)


def test_who_does_not_learn_keeps_its_weights_and_forgets_its_rollout():
    individuals = minds()
    table, before = herd(individuals, 9), {}
    for tick in range(9):
        live(table, individuals, tick, rates=lambda uid: np.where(uid < 5, 0, 0.01))
        before = before or {
            int(u): table[Policy].weights[int(r)].tobytes()
            for u, r in zip(table.uid, table.by_uid(), strict=False)
        }
    same = {
        int(u): table[Policy].weights[int(r)].tobytes() == before[int(u)]
        for u, r in zip(table.uid, table.by_uid(), strict=False)
    }
    assert same == {u: u < 5 for u in range(1, 10)}
    assert not table[Policy].steps[table.by_uid()[:4]].any()
    first = [mix_int(u) % 8 or 8 for u in range(1, 10)]  # each learnt once, at this age
    assert table[Experience].length[table.by_uid()].tolist() == [9 - age for age in first]
