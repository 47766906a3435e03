"""The decision is exactly H(y + z)."""

import numpy as np
import pytest

from ecs_eco.engine.random import DECIDE, draw, tick_key
from ecs_eco.nervous.decision import HIGHEST, Will, all_finite, decide, first_on, uniforms
from ecs_eco.nervous.nerves import Nerves


def _nerves(groups, neutral=None, automatic=()):
    return Nerves((), [], groups, neutral or {}, automatic, {})


def _decide(nerves, choice, y, policy=True):
    """Run the kernel with one organism per row of `choice` and `y`; organism i has row 2 i + 1."""
    n = max(len(choice), len(y))
    decision = np.full((2 * n + 1, len(nerves.actions)), 7, np.uint8)
    rows = 2 * np.arange(n) + 1
    choice = np.array(choice, np.int16).reshape(n, -1) if policy else np.zeros((n, 0), np.int16)
    reflex = np.array(y if len(y) else np.zeros((1, 1)), np.int8)
    will = Will(nerves.offsets, nerves.targets, policy, reflex, len(y) > 0, nerves.automatic)
    decide(0, n, choice, will, rows, decision)
    assert (decision[::2] == 7).all()  # nobody else's
    return decision[rows].tolist()


@pytest.mark.parametrize(
    ("y", "z", "h"), [(-1, 0, 0), (-1, 1, 0), (0, 0, 0), (0, 1, 1), (1, 0, 1), (1, 1, 1)]
)
@pytest.mark.definition("5 decision")
def test_each_combination_of_reflex_and_policy(y, z, h):
    nerves = _nerves({"speed": ["walk", "run"]})
    chosen = 0 if z else 1
    assert _decide(nerves, [[chosen]], [[y, 0]])[0][0] == h


def test_h_of_y_plus_z_for_whole_vectors():
    nerves = _nerves({"speed": ["still", "walk", "run"], "turn": ["left", "right"]})
    rng = np.random.default_rng(0)
    choice = np.stack([rng.integers(0, 3, 50), rng.integers(0, 2, 50)], 1)
    y = rng.integers(-1, 2, (50, 5))
    z = np.zeros((50, 5), int)
    z[np.arange(50), choice[:, 0]] = 1
    z[np.arange(50), 3 + choice[:, 1]] = 1
    assert _decide(nerves, choice, y) == (y + z > 0).astype(int).tolist()


@pytest.mark.definition("3 reflex agents")
def test_without_reflex_the_policy_decides_and_without_policy_the_reflex():
    nerves = _nerves({"speed": ["still", "walk", "run"]})
    assert _decide(nerves, [[2], [0]], []) == [[0, 0, 1], [1, 0, 0]]
    assert _decide(nerves, [], [[0, 1, 1], [-1, 0, 0]], policy=False) == [[0, 1, 1], [0, 0, 0]]


def test_a_lone_action_can_be_left_undone():
    nerves = _nerves({"eat": ["eat"], "speed": ["still", "run"]})
    assert nerves.choices == (2, 2)
    assert nerves.targets.tolist() == [-1, 0, 1, 2]  # "not", eat, still, run
    assert nerves.offsets.tolist() == [0, 2, 4]
    assert _decide(nerves, [[0, 0], [1, 1]], []) == [[0, 1, 0], [1, 0, 1]]
    assert _decide(nerves, [[0, 0], [1, 1]], [[1, 0, 0], [-1, 0, 0]]) == [[1, 1, 0], [0, 0, 1]]


def test_automatic_actions_are_on_unless_a_reflex_blocks_them():
    nerves = _nerves({"eat": ["eat"], "speed": ["still", "run"]}, automatic=["eat"])
    assert nerves.choices == (2,)  # the policy has no say in it
    assert _decide(nerves, [[0]] * 3, [[-1, 0, 0], [0, 0, 0], [1, 0, 0]]) == [[0, 1, 0], [1, 1, 0], [1, 1, 0]]
    full = _nerves({"eat": ["eat"], "speed": ["still", "run"]}, automatic=["eat.eat"])
    assert full.automatic.tolist() == [True, False, False]


def test_the_first_that_is_on_is_done_and_the_neutral_one_where_none_is():
    decision = np.array([[9, 0, 1, 1], [9, 1, 1, 0], [9, 0, 0, 0]], np.uint8)
    assert [first_on(decision, row, 1, 3, 2) for row in range(3)] == [1, 0, 2]
    assert first_on(decision, 2, 1, 3, -1) == -1


def test_columns_follow_the_order_of_groups_and_actions():
    nerves = _nerves({"speed": ["still", "run"], "turn": ["left", "none"], "eat": ["eat"]}, {"turn": "none"})
    assert nerves.columns == {"speed": (0, 2), "turn": (2, 2), "eat": (4, 1)}
    assert nerves.neutral == {"speed": -1, "turn": 1, "eat": -1}
    assert [nerves.column(a) for a in ("run", "speed.run", "turn.none", "eat")] == [1, 1, 3, 4]
    with pytest.raises(KeyError, match=r"unknown or ambiguous action .*rnu.*speed.still, speed.run"):
        nerves.column("rnu")
    with pytest.raises(KeyError, match="ambiguous"):
        _nerves({"speed": ["none"], "turn": ["none"]}).column("none")


def test_uniforms_are_drawn_by_uid_and_group():
    uid, key = np.array([5, 9], np.uint64), tick_key(1, 2)
    out = np.zeros((2, 3), np.float32)
    uniforms(0, 2, key, uid, 0, out)
    assert out.tolist() == [[draw(key, u, DECIDE + (g << 8)) for g in range(3)] for u in uid]
    assert len(set(out.ravel().tolist())) == 6
    uniforms(0, 2, key, uid, 1, out[:, :2])
    assert out[0, :2].tolist() == [draw(key, uid[0], DECIDE + (g << 8)) for g in (1, 2)]


@pytest.mark.parametrize("wild", [np.nan, np.inf, -np.inf])
def test_one_number_that_is_not_finite_is_found_among_logits_and_values(wild):
    logits, values = np.full(35, -HIGHEST, np.float32), np.full(5, HIGHEST, np.float32)
    assert all_finite(logits, values)
    for numbers in (logits, values):
        numbers[-1] = wild
        assert not all_finite(logits, values)
        numbers[-1] = 0
    assert all_finite(logits[:0], values[:0])
