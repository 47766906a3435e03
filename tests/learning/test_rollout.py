import numpy as np
import pytest

from ecs_eco.learning import Rollout

F = np.float32


def _rows(*rows):
    return np.array(rows, np.int64)


def _store(rollout, rows, values, mark=0.0):
    n = len(rows)
    observations = np.full((n, 2), mark, F) + np.arange(n, dtype=F)[:, None]
    rollout.store(
        _rows(*rows), observations, np.zeros((n, 1), np.int8), np.full(n, -0.5, F), np.array(values, F)
    )


def _numbers(*x):
    return np.array(x, F)


def test_advantages_with_a_death_a_birth_into_its_row_and_a_cut():
    """Discount 0.5, lambda 0.5; rows 0 and 1 start, 1 dies, is born anew, row 2 is cut by a time limit."""
    rollout = Rollout(2, 1, discount=0.5)
    _store(rollout, [0, 1, 2], [1.0, 2.0, 3.0])  # records 0, 1, 2
    rollout.credit(_rows(0), _numbers(1.0))
    rollout.end(_rows(1), _numbers(-4.0))  # record 1: dies
    rollout.cut(_rows(2), _numbers(2.0), _numbers(8.0))  # record 2: 2 + 0.5 * 8 = 6
    _store(rollout, [1, 0], [5.0, 1.5])  # record 3: newborn in row 1; record 4: row 0 lives on
    rollout.credit(_rows(0, 1), _numbers(0.5, 0.25))
    _store(rollout, [0], [2.0])  # record 5
    rollout.credit(_rows(0), _numbers(3.0))
    rollout.advantages(_rows(1, 0), _numbers(4.0, 6.0), gae_lambda=0.5)
    a5 = 3 + 0.5 * 6 - 2  # 4
    a4 = 0.5 + 0.5 * 2 - 1.5 + 0.25 * a5  # 1
    a0 = 1 + 0.5 * 1.5 - 1 + 0.25 * a4  # 1
    a3 = 0.25 + 0.5 * 4 - 5  # -2.75
    assert rollout.steps["advantage"].tolist() == [a0, -4 - 2, 6 - 3, a3, a4, a5] == [1, -6, 3, -2.75, 1, 4]
    assert rollout.ended.tolist() == [False, True, True, False, False, False]


def test_rewards_before_the_first_action_and_after_death_are_nobodys():
    rollout = Rollout(2, 1, discount=0.9)
    _store(rollout, [3], [0.0])
    rollout.credit(_rows(0, 3, 50), _numbers(5, 1, 7))
    rollout.end(_rows(3), _numbers(1))
    rollout.credit(_rows(3), _numbers(100))
    rollout.end(_rows(3), _numbers(100))
    assert rollout.steps["reward"].tolist() == [2]


def test_living_rows_without_a_value_are_named():
    rollout = Rollout(2, 1, discount=0.9)
    _store(rollout, [0, 4], [0, 0])
    with pytest.raises(ValueError, match=r"rows \[4\] \(1 in all\) have open records but no finite value"):
        rollout.advantages(_rows(0), _numbers(1), 0.9)
    with pytest.raises(ValueError, match=r"rows \[0\]"):
        rollout.advantages(_rows(0, 4), _numbers(np.nan, 1), 0.9)


def test_advantages_of_many_lives_agree_with_each_life_alone():
    """Random births, deaths and cuts in 20 rows; the twin keeps a list per animal."""
    rng, rollout = np.random.default_rng(5), Rollout(2, 1, discount=0.9)
    lives, alive = [], {}  # a life: list of [record, reward, value], and what follows it
    for row in range(20):
        alive[row] = []
    n = 0
    for _ in range(40):
        rows = rng.permutation(list(alive))
        values = rng.normal(size=len(rows)).astype(F)
        _store(rollout, rows, values)
        for row, value in zip(rows, values, strict=True):
            alive[row].append([n, 0.0, float(value)])
            n += 1
        for row in list(rows):
            reward, fate = float(F(rng.normal())), rng.random()
            alive[row][-1][1] = reward
            if fate < 0.1:
                rollout.end(_rows(row), _numbers(reward))
                lives.append((alive.pop(row), 0.0))
            elif fate < 0.2:
                rollout.cut(_rows(row), _numbers(reward), _numbers(3.0))
                lives.append((alive.pop(row), 3.0))
            else:
                rollout.credit(_rows(row), _numbers(reward))
        for row in set(range(20)) - set(alive):
            if rng.random() < 0.5:
                alive[row] = []
    rows = [row for row in alive if alive[row]]
    rollout.advantages(_rows(*rows), np.full(len(rows), 2.0, F), 0.8)
    lives += [(alive[row], 2.0) for row in rows]
    right = np.empty(n)
    for life, after in lives:
        gain = 0.0
        for record, reward, value in reversed(life):
            gain = reward + 0.9 * after - value + 0.9 * 0.8 * gain
            right[record], after = gain, value
    assert len(lives) > 60
    np.testing.assert_allclose(rollout.steps["advantage"], right, rtol=1e-4, atol=1e-5)


def test_growth_keeps_what_is_stored():
    rollout = Rollout(2, 1, discount=0.9)
    for tick in range(100):
        _store(rollout, range(tick % 7 + 1), np.full(tick % 7 + 1, tick), mark=tick)
    marks = [tick + i for tick in range(100) for i in range(tick % 7 + 1)]
    assert rollout.observations[:, 1].tolist() == marks
    assert rollout.n == len(marks)
    assert rollout.ticks == 100


def test_clearing_forgets_the_records_of_the_living():
    rollout = Rollout(2, 1, discount=0.9)
    _store(rollout, [0], [1.0])
    rollout.clear()
    rollout.credit(_rows(0), _numbers(5))
    _store(rollout, [0], [1.0])
    assert (rollout.n, rollout.ticks) == (1, 1)
    assert rollout.steps["reward"].tolist() == [0]


def test_a_loaded_rollout_goes_on_as_the_saved_one():
    first = Rollout(2, 1, discount=0.9)
    _store(first, [0, 5], [1.0, 2.0])
    first.end(_rows(0), _numbers(1))
    second = Rollout(2, 1, discount=0.9)
    second.load(first.state())
    for rollout in (first, second):
        rollout.credit(_rows(5), _numbers(2))
        _store(rollout, [0, 5], [1.0, 2.0])
        rollout.advantages(_rows(0, 5), _numbers(1, 1), 0.9)
    assert all(np.array_equal(first.state()[name], second.state()[name]) for name in first.state())


def test_a_rollout_of_another_width_is_refused():
    with pytest.raises(ValueError, match="observations of the rollout"):
        Rollout(3, 1, 0.9).load(Rollout(2, 1, 0.9).state())


def test_bytes_per_transition_are_those_of_all_columns():
    rollout = Rollout(24, 2, 0.9)
    assert rollout.nbytes_per_transition == 24 * 4 + 2 * 2 + 5 * 4 + 1
    _store(rollout := Rollout(2, 1, 0.9), [0], [0])
    assert rollout.nbytes_per_transition == 2 * 4 + 2 + 5 * 4 + 1


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("last", 10**6, "last of the rollout points outside its 3 transitions"),
        ("last", -7, "last of the rollout points"),
        ("row", 10**6, "row of the rollout is 1000000 to 1000000; expected: 0 to 2"),
        ("row", -1, "row of the rollout is -1"),
    ],
)
def test_a_state_that_points_beyond_itself_is_refused(name, value, message):
    rollout = Rollout(2, 1, 0.9)
    rollout.store(
        np.arange(3), np.zeros((3, 2), np.float32), np.zeros((3, 1), np.int16), *np.zeros((2, 3), np.float32)
    )
    state = rollout.state()
    state[name][...] = value
    with pytest.raises(ValueError, match=message):
        Rollout(2, 1, 0.9).load(state)


def test_a_state_with_parts_of_other_lengths_is_refused():
    rollout = Rollout(2, 1, 0.9)
    rollout.store(
        np.arange(3), np.zeros((3, 2), np.float32), np.zeros((3, 1), np.int16), *np.zeros((2, 3), np.float32)
    )
    with pytest.raises(ValueError, match="value of the rollout has 2 transitions, but ended has 3"):
        Rollout(2, 1, 0.9).load(rollout.state() | {"value": np.zeros(2, np.float32)})
