"""The decision: H(y + z), with y from the reflex and z from the policy (the paper's section on
decision-making)."""

from typing import NamedTuple

import numpy as np

from ecs_eco.compiled.jit import lone_njit, njit
from ecs_eco.engine import random
from ecs_eco.engine.random import draw

HIGHEST = np.finfo(np.float32).max


class Will(NamedTuple):
    """Reflexes and always-active actions, for kernels."""

    offsets: np.ndarray  # offset of each group among all options
    targets: np.ndarray  # action of each option, −1: none
    has_policy: bool
    reflex: np.ndarray  # y, i8[n, actions]
    has_reflex: bool
    automatic: np.ndarray  # bool[actions]


@njit
def all_finite(logits, values):
    """Return whether all numbers in two flat arrays are finite. Branch-free, so that it vectorizes."""
    beyond = False
    for i in range(logits.size):
        beyond |= not abs(logits[i]) <= HIGHEST  # also true for NaN
    for i in range(values.size):
        beyond |= not abs(values[i]) <= HIGHEST
    return not beyond


@lone_njit
def uniforms(first, last, key, uid, group, out):
    """Draw the random numbers `out` f32[n, groups] that select actions in group `group` and all later groups;
    each uid always gets the same numbers."""
    for g in range(out.shape[1]):
        for k in range(last - first):
            i = np.uint64(first + k)
            out[i, np.uint64(g)] = draw(key, uid[i], random.DECIDE + ((group + g) << 8))


@njit
def decide(
    first: int, last: int, choice: np.ndarray, will: Will, rows: np.ndarray, decision: np.ndarray
) -> None:
    """Write H(y + z) of organism i to decision[rows[i]]: u8[capacity, actions].

    z is 1 for the chosen action of each group (choice[i, g] indexes the group's options, targets maps options
    to actions) and for automatic actions; y is −1, 0 or 1; H(v) = 1 if v > 0.
    """
    offsets, targets, has_policy, y, has_reflex, automatic = will
    n_actions = decision.shape[1]
    for i in range(first, last):
        row = rows[i]
        for a in range(n_actions):
            decision[row, a] = 1 if automatic[a] else 0
        if has_policy:
            for g in range(choice.shape[1]):
                a = targets[offsets[g] + choice[i, g]]
                if a >= 0:
                    decision[row, a] = 1
        if has_reflex:
            for a in range(n_actions):
                decision[row, a] = 1 if np.int32(decision[row, a]) + np.int32(y[i, a]) > 0 else 0


@njit
def first_on(decision, row, start, n, neutral):
    """Return the executed action of a group: the first active one in declared order, or the default if none
    is active."""
    for a in range(n):
        if decision[row, start + a]:
            return a
    return neutral


@lone_njit
def first_of(decision, first, size, start, n, neutral, way):
    """Write `first_on` for the rows starting at `first` to way i32[size]. Branch-free, because actions are
    unpredictable."""
    for i in range(size):
        way[i] = neutral
    for k in range(n):
        a = np.int32(n - 1 - k)
        for i in range(size):
            way[i] = a if decision[first + i, start + a] else way[i]
